#include "render_client/renderer/cpu/tile_merge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/texture_sampling.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr float kPerAlpha = 1.0F / 255;
constexpr float kNothing = 1e-30F;       // Less than any weight.
constexpr std::uint16_t kHalf = 1 << 7;  // One half in units of 1/256.

// A row is merged in spans of this many pixels, and each span in three short passes. One long loop
// body would be slower, since a processor reorders only a few hundred instructions.
constexpr int kSpan = 64;
constexpr int kGroups = kSpan / kLanes;

// Intermediate results for one camera's fragments.
struct CameraSpan {
  // The value is 0 if the fragment does not contribute to the pixel, and 1 if no other camera's
  // fragment does.
  alignas(32) std::array<float, kSpan> weight_per_incidence;
  // Texels as in CameraTexture. They are valid where the weight is not 0.
  alignas(32) std::array<std::uint32_t, kSpan> colors;
};

struct Span {
  std::array<CameraSpan, kMostViews> cameras;
  // Inverse depths of the nearest fragments in the span and in the pixel after it.
  alignas(32) std::array<float, kSpan + kLanes> nearest;
  alignas(32) std::array<std::int32_t, kSpan> first;  // Camera of the nearest fragment.
  alignas(32) std::array<std::int32_t, kSpan> shown;  // All bits are set where there is a fragment.
  // Whether fragments of several cameras contribute to a pixel of the group.
  std::array<bool, kGroups> is_contested;
};

class SpanMerge {
 public:
  SpanMerge(std::span<const MergeCamera> cameras, std::span<const Tile> tiles, const MergeSettings& settings,
            MergedView& view, Image<float>& inverse, TileBorders& borders)
      : all_cameras_(cameras),
        tiles_(tiles),
        wanted_(settings.wanted),
        nearest_only_(settings.mode == MergeMode::kNearest),
        tie_ratio_(tie_ratio(settings.mode)),
        background_(all(settings.background.r | settings.background.g << 8 | settings.background.b << 16)),
        apart_(settings.silhouette_step),
        empty_(tiles[0].empty()),
        view_(view),
        inverse_(inverse),
        borders_(borders),
        between_columns_((view.width + kLanes - 1) / kLanes, tiles[0].rows()),
        between_rows_(between_columns_.width(), between_columns_.height()) {
    for (BorderRow* const row : {&borders.first, &borders.last})
      row->nearest.resize(static_cast<std::size_t>(between_columns_.width()) * kLanes);
  }

  // Merges the columns [x, x + kSpan) of the tile, as far as they belong to the view.
  void merge_columns(int x) {
    const int groups = (std::min(kSpan, view_.width - x) + kLanes - 1) / kLanes;
    select_cameras(x, groups);
    const int top = tiles_[0].top();
    for (int y = top; y < top + tiles_[0].rows(); ++y) {
      switch (cameras_) {
        case 1:
          run<1>(x, y, groups);
          break;
        case 2:
          run<2>(x, y, groups);
          break;
        default:
          run<0>(x, y, groups);
      }
    }
  }

  // Softens the silhouette edges of all merged spans.
  void soften() {
    const int top = tiles_[0].top(), bottom = top + tiles_[0].rows() - 1;
    soften_between_columns(between_columns_, top, view_);
    borders_.first.color.assign(view_.color.row(top).begin(), view_.color.row(top).end());
    borders_.last.color.assign(view_.color.row(bottom).begin(), view_.color.row(bottom).end());
    soften_between_rows(between_rows_, top, view_);
  }

  // The number of pixels that show a fragment.
  std::size_t shown() const { return shown_; }

 private:
  // The functions with this parameter work on the selected cameras. Their number is kCount, or
  // cameras_ if kCount is 0.
  template <std::size_t kCount>
  std::size_t count() const {
    return kCount ? kCount : cameras_;
  }

  // Selects the cameras that have a fragment in these columns, and at least one camera.
  void select_cameras(int x, int groups) {
    cameras_ = 0;
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      if (has_fragments(tiles_[i], x, groups)) select(i);
    }
    if (cameras_ == 0) select(0);
  }

  void select(std::size_t i) {
    selected_[cameras_] = &all_cameras_[i];
    tile_[cameras_] = &tiles_[i];
    noise_per_square_[cameras_] = uncertainty_per_square(all_cameras_[i].noise);
    ++cameras_;
  }

  static bool has_fragments(const Tile& tile, int x, int groups) {
    if (tile.right() <= x || tile.left() >= x + groups * kLanes) return false;
    for (int y = tile.top(); y < tile.top() + tile.rows(); ++y) {
      const float* const depths = tile.depths(y) + x;
      Ints found{};
      for (int g = 0; g < groups; ++g) found |= load<Floats>(depths + g * kLanes) > tile.empty();
      if (bits(found)) return true;
    }
    return false;
  }

  // Merges `groups` groups of eight pixels from (x, y) on. The last one may reach beyond the view.
  // Requires that the rows of a span follow one another.
  template <std::size_t kCount>
  void run(int x, int y, int groups) {
    y_ = y;
    for (std::size_t i = 0; i < count<kCount>(); ++i) {
      depths_[i] = tile_[i]->depths(y) + x;
      texels_[i] = tile_[i]->texels(y) + x;
      depth_of_row_[i] = selected_[i]->depth[1] * static_cast<float>(y) + selected_[i]->depth[2];
    }
    survey<kCount>(x, groups);
    if (wanted_.color) keep_silhouettes<kCount>(x, groups);
    for (std::size_t i = 0; i < count<kCount>(); ++i) sample(i, groups);
    Rgba8* const pixels = wanted_.color ? view_.color.row(y).data() + x : nullptr;
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Ints best = load<Ints>(&span_.first[at]);
      const Ints colors = span_.is_contested[g] ? mixture<kCount>(at, best) : first_colors<kCount>(at);
      const int count = std::min(kLanes, view_.width - (x + at));
      if (wanted_.color) write_colors(pixels + at, count, colors, load<Ints>(&span_.shown[at]));
      if (wanted_.depth) write_depths(x, at, count, best);
      if (inverse_.width() > 0) write_inverse(x + at, count, at);
    }
  }

  // Computes the weights of all cameras' fragments.
  template <std::size_t kCount>
  void survey(int x, int groups) {
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Floats w[kMostViews];
      Floats nearest = w[0] = load<Floats>(depths_[0] + at);
      Ints first{}, overlap{}, shown = nearest > empty_;
      for (std::size_t i = 1; i < count<kCount>(); ++i) {
        w[i] = load<Floats>(depths_[i] + at);
        const Ints there = w[i] > empty_;
        overlap |= shown & there;
        shown |= there;
        first = w[i] > nearest ? all(static_cast<std::int32_t>(i)) : first;
        nearest = larger(w[i], nearest);
      }
      store(&span_.nearest[at], nearest);
      store(&span_.first[at], first);
      store(&span_.shown[at], shown);
      if (bits(overlap) && !nearest_only_) {
        span_.is_contested[g] = compute_weights<kCount>(x, at, w);
      } else {
        span_.is_contested[g] = false;
        for (std::size_t i = 0; i < count<kCount>(); ++i) {
          const Ints is_first = shown & (first == static_cast<std::int32_t>(i));
          store(&span_.cameras[i].weight_per_incidence[at], is_first ? all(1.0F) : Floats{});
        }
      }
    }
  }

  template <std::size_t kCount>
  void keep_silhouettes(int x, int groups) {
    // A tile's rows have a spare group of pixels beyond the view.
    const int end = groups * kLanes;
    span_.nearest[end] = depths_[0][end];
    for (std::size_t i = 1; i < count<kCount>(); ++i)
      span_.nearest[end] = std::max(span_.nearest[end], depths_[i][end]);
    const int row = y_ - tiles_[0].top();
    std::uint8_t* const between_columns = between_columns_.row(row).data() + x / kLanes;
    for (int g = 0; g < groups; ++g) {
      const float* const nearest = &span_.nearest[g * kLanes];
      between_columns[g] = find_silhouettes(load<Floats>(nearest), load<Floats>(nearest + 1), empty_, apart_);
    }
    if (row > 0) {
      std::uint8_t* const between_rows = between_rows_.row(row - 1).data() + x / kLanes;
      for (int g = 0; g < groups; ++g) {
        const int at = g * kLanes;
        between_rows[g] =
            find_silhouettes(load<Floats>(&above_[at]), load<Floats>(&span_.nearest[at]), empty_, apart_);
      }
    }
    std::copy_n(span_.nearest.begin(), kSpan, above_.begin());
    if (row == 0) keep_border(x, groups, borders_.first);
    if (row == tiles_[0].rows() - 1) keep_border(x, groups, borders_.last);
  }

  void keep_border(int x, int groups, BorderRow& border) const {
    for (int at = 0; at < groups * kLanes; at += kLanes) {
      const auto nearest = load<Floats>(&span_.nearest[at]);
      store(&border.nearest[x + at], nearest > empty_ ? nearest : Floats{});
    }
  }

  Floats camera_depth(std::size_t i, int x, const Floats& z) const {
    const Eigen::Vector4f& d = selected_[i]->depth;
    const Floats pixel_x = ramp() + static_cast<float>(x);
    return z * (d[0] * pixel_x + depth_of_row_[i]) + d[3];
  }

  // Computes the weights of every camera's fragments at eight pixels: blend_weight() of
  // merge_rules.h up to a common factor and without its factor cos(theta). Returns whether a
  // fragment other than the nearest contributes.
  template <std::size_t kCount>
  bool compute_weights(int x, int at, const Floats (&w)[kMostViews]) {
    Floats z[kMostViews], noise[kMostViews], uncertainty[kMostViews];
    Floats nearest = w[0], nearest_z{}, nearest_uncertainty{};
    for (std::size_t i = 0; i < count<kCount>(); ++i) {
      z[i] = 1.0F / w[i];
      const Floats camera_z = camera_depth(i, x + at, z[i]);
      noise[i] = noise_per_square_[i] * (camera_z * camera_z);
      uncertainty[i] = noise[i] + selected_[i]->calibration_error_m;
      nearest_z = i == 0 ? z[i] : smaller(z[i], nearest_z);
      nearest_uncertainty = i == 0 || w[i] > nearest ? uncertainty[i] : nearest_uncertainty;
      nearest = larger(w[i], nearest);
    }
    Ints rivals{}, counting{};
    for (std::size_t i = 0; i < count<kCount>(); ++i) {
      const Floats range = uncertainty[i] + nearest_uncertainty;
      // Distance from the fragment to the end of the uncertainty range.
      const Floats room = range - (z[i] - nearest_z);
      const Floats fading = smaller(room + room, range);
      const Ints counts = (w[i] > empty_) & (room > 0);
      rivals |= counting & counts;
      counting |= counts;
      store(&span_.cameras[i].weight_per_incidence[at], counts ? fading / (noise[i] * range) : Floats{});
    }
    return bits(rivals) != 0;
  }

  // Samples a camera's texture where its fragments contribute.
  void sample(std::size_t i, int groups) {
    CameraSpan& camera = span_.cameras[i];
    const TextureSampler texture(*selected_[i]->texture);
    const std::uint32_t* const texels = texels_[i];
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      const Ints counts = load<Floats>(&camera.weight_per_incidence[at]) > 0;
      if (!bits(counts)) continue;
      // The other lanes read the first texel, which is always valid.
      const Ints colors = texture.at(counts & load<Ints>(texels + at));
      store(&camera.colors[at],
            selected_[i]->opacity_256 == 256 ? colors : faded(colors, selected_[i]->opacity_256));
    }
  }

  // Multiplies red, green and blue by the opacity. Alpha stays.
  static Ints faded(const Ints& colors, int opacity_256) {
    const auto times = [&](const Words& channels) {
      return (channels * static_cast<std::uint16_t>(opacity_256) + kHalf) >> 8;
    };
    const Ints rb = reinterpret_cast<Ints>(times(red_blue(colors)));
    const Ints g = reinterpret_cast<Ints>(times(reinterpret_cast<Words>(colors & 0xFF00) >> 8)) << 8;
    return rb | g | (colors & static_cast<std::int32_t>(0xFF000000U));
  }

  // Returns the colours of a group in which only one camera contributes to each pixel.
  template <std::size_t kCount>
  Ints first_colors(int at) const {
    Ints colors{};
    for (std::size_t i = 0; i < count<kCount>(); ++i) {
      const CameraSpan& camera = span_.cameras[i];
      colors |= (load<Floats>(&camera.weight_per_incidence[at]) > 0) & load<Ints>(&camera.colors[at]);
    }
    return colors;
  }

  static Floats alpha(const Ints& colors) {
    return as_floats(reinterpret_cast<Ints>(reinterpret_cast<UnsignedInts>(colors) >> 24));
  }
  static Words red_blue(const Ints& colors) { return reinterpret_cast<Words>(colors & 0x00FF00FF); }
  static Words green_alpha(const Ints& colors) { return reinterpret_cast<Words>(colors) >> 8; }

  // Mixes the colours of all cameras by blend_share() of merge_rules.h. Sets `best` to the camera
  // with the greatest weight.
  template <std::size_t kCount>
  Ints mixture(int at, Ints& best) const {
    const auto weight_of = [&](std::size_t i, const Ints& colors) {
      return alpha(colors) * load<Floats>(&span_.cameras[i].weight_per_incidence[at]);
    };
    // The best fragment so far, and all other fragments.
    Ints best_colors = load<Ints>(&span_.cameras[0].colors[at]), other_colors[kMostViews];
    Floats best_weight = weight_of(0, best_colors), other_weight[kMostViews];
    best = Ints{};
    for (std::size_t i = 1; i < count<kCount>(); ++i) {
      const Ints colors = load<Ints>(&span_.cameras[i].colors[at]);
      const Floats weight = weight_of(i, colors);
      const Ints is_better = weight > best_weight;
      best = is_better ? all(static_cast<std::int32_t>(i)) : best;
      other_colors[i] = is_better ? best_colors : colors;
      best_colors = is_better ? colors : best_colors;
      other_weight[i] = smaller(weight, best_weight);
      best_weight = larger(weight, best_weight);
    }
    const Floats least_weight = tie_ratio_ * best_weight;
    Floats sum = (best_weight - least_weight) + kNothing;
    for (std::size_t i = 1; i < count<kCount>(); ++i) {
      other_weight[i] = larger(other_weight[i] - least_weight, Floats{});
      sum += other_weight[i];
    }
    // Adds shares of the differences to the best colour, in units of 1/256. So the shares always
    // add up to 1. Products wrap modulo 2^16, but their sum is a valid colour.
    const Floats per_sum = 256.0F / sum;
    const Words best_rb = red_blue(best_colors), best_ga = green_alpha(best_colors);
    Words rb = (best_rb << 8) + kHalf, ga = (best_ga << 8) + kHalf;
    for (std::size_t i = 1; i < count<kCount>(); ++i) {
      const Ints in_256ths = truncated(other_weight[i] * per_sum);
      const auto share = reinterpret_cast<Words>(in_256ths | in_256ths << 16);
      rb += (red_blue(other_colors[i]) - best_rb) * share;
      ga += (green_alpha(other_colors[i]) - best_ga) * share;
    }
    return reinterpret_cast<Ints>(rb >> 8) |
           (reinterpret_cast<Ints>(ga) & static_cast<std::int32_t>(0xFF00FF00U));
  }

  void write_colors(Rgba8* to, int count, const Ints& colors, const Ints& shown) {
    static_assert(sizeof(Rgba8) * kLanes == sizeof colors);
    const Ints pixels = shown ? colors | static_cast<std::int32_t>(0xFF000000U) : background_;
    store_first(to, pixels, count);
    shown_ += static_cast<std::size_t>(std::popcount(bits(shown) & ((1U << count) - 1)));
  }

  void write_inverse(int x, int count, int at) const {
    const Floats w = load<Ints>(&span_.shown[at]) != 0 ? load<Floats>(&span_.nearest[at]) : Floats{};
    store_first(inverse_.row(y_).data() + x, w, count);
  }

  // Writes depth, camera and quality of `count` pixels from x + at on.
  void write_depths(int x, int at, int count, const Ints& best) {
    for (int lane = 0; lane < count; ++lane) {
      const int here = x + at + lane, camera = best[lane];
      const bool shown = span_.shown[at + lane] != 0;
      view_.camera(here, y_) = shown ? static_cast<std::uint8_t>(selected_[camera]->index) : kNoCamera;
      if (!shown) {
        view_.depth_m(here, y_) = view_.quality(here, y_) = 0;
        continue;
      }
      const float z = 1.0F / depths_[camera][at + lane];
      const float camera_z = camera_depth(camera, here, all(z))[0];
      view_.depth_m(here, y_) = z;
      view_.quality(here, y_) =
          precision(selected_[camera]->noise) *
          (kPerAlpha * static_cast<float>(span_.cameras[camera].colors[at + lane] >> 24) /
           (camera_z * camera_z));
    }
  }

  std::span<const MergeCamera> all_cameras_;
  std::span<const Tile> tiles_;
  HostPixels wanted_;
  bool nearest_only_;
  float tie_ratio_;
  Ints background_;
  float apart_;  // Minimum difference in inverse depth at a silhouette edge, 1/m.
  float empty_;
  int y_ = 0;
  // The selected cameras.
  std::size_t cameras_ = 0;
  const MergeCamera* selected_[kMostViews];
  const Tile* tile_[kMostViews];
  const float* depths_[kMostViews];  // Pointers to the first elements of the span.
  const std::uint32_t* texels_[kMostViews];
  float depth_of_row_[kMostViews];      // The term b y + c of MergeCamera::depth.
  float noise_per_square_[kMostViews];  // The uncertainty_per_square() of each camera.
  MergedView& view_;
  Image<float>& inverse_;
  TileBorders& borders_;
  SilhouetteBits between_columns_, between_rows_;
  std::size_t shown_ = 0;
  Span span_;
  alignas(32) std::array<float, kSpan> above_;  // Span::nearest of the row above.
};

}  // namespace

MergeCamera merge_camera(const CameraView& camera, const ViewPose& eye, const CameraTexture& texture,
                         float brightness) {
  const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
  const Eigen::Vector3d row = camera_from_eye.rotation.row(2);
  const double a = row.x() / eye.intrinsics.fx, b = row.y() / eye.intrinsics.fy;
  MergeCamera source;
  source.texture = &texture;
  source.depth = Eigen::Vector4d(a, b, row.z() - a * eye.intrinsics.cx - b * eye.intrinsics.cy,
                                 camera_from_eye.translation.z())
                     .cast<float>();
  source.calibration_error_m = static_cast<float>(camera.calibration_error_m);
  source.noise = camera.noise;
  const float opacity = camera.opacity * (camera.is_remembered ? brightness : 1);
  if (opacity < 1) source.opacity_256 = std::min(static_cast<int>(256 * opacity + 0.5F), 255);
  source.rank = rank(camera.opacity, camera.is_remembered);
  return source;
}

std::size_t merge_tile(std::span<const MergeCamera> cameras, std::span<const Tile> tiles,
                       const MergeSettings& settings, MergedView& view, Image<float>& inverse,
                       TileBorders& borders) {
  assert(!cameras.empty() && cameras.size() <= kMostViews && cameras.size() == tiles.size());
  SpanMerge merge(cameras, tiles, settings, view, inverse, borders);
  // A tile is merged in columns of spans, since rows of a column read nearly the same texels.
  for (int x = 0; x < view.width; x += kSpan) merge.merge_columns(x);
  if (settings.wanted.color) merge.soften();
  return merge.shown();
}

}  // namespace copresence::renderer
