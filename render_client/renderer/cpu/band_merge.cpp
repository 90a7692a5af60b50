#include "render_client/renderer/cpu/band_merge.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/outlines.h"
#include "render_client/renderer/cpu/texture_sampling.h"
#include "render_client/renderer/merge_rules.h"

namespace copresence::renderer {
namespace {

constexpr float kPerAlpha = 1.0F / 255;
constexpr float kNothing = 1e-30F;       // worth less than any fragment
constexpr std::uint16_t kHalf = 1 << 7;  // in 256ths

// A row is merged in spans of this many pixels, and a span in three short passes: one long loop body would
// wait for its own results, since a processor looks only a few hundred instructions ahead.
constexpr int kSpan = 64;
constexpr int kGroups = kSpan / kLanes;

// What the passes tell each other about one camera's fragments.
struct CameraSpan {
  alignas(32) std::array<float, kSpan> worth_per_cosine;  // 0: does not count; 1 where no other camera's does
  alignas(32) std::array<std::uint32_t, kSpan> colors;    // where it counts; alpha as in Texture
};

struct Span {
  std::array<CameraSpan, kMostCameras> cameras;
  alignas(32) std::array<float, kSpan + kLanes> nearest;  // inverse depth, of the span and the pixel after it
  alignas(32) std::array<std::int32_t, kSpan> first;      // the nearest fragment's camera
  alignas(32) std::array<std::int32_t, kSpan> shown;      // all bits set where there is anything
  std::array<bool, kGroups> is_contested;                 // several cameras may count somewhere in the group
};

// kCount: the number of cameras where the compiler is to know it, 0 where it is not.
template <std::size_t kCount>
class SpanMerge {
 public:
  SpanMerge(std::span<const MergeSource> sources, std::span<const Band> bands, MergedView& view)
      : sources_(sources),
        bands_(bands),
        empty_(bands[0].empty()),
        view_(view),
        outline_(outline_of(sources)),
        outlines_((view.width + kLanes - 1) / kLanes, bands[0].rows()) {
    for (std::size_t i = 0; i < count(); ++i) noise_per_square_[i] = uncertainty_per_square(sources[i].noise);
  }

  // Merges `groups` groups of eight pixels from (x, y) on. The last may reach beyond the view.
  void run(int x, int y, int groups, HostPixels wanted) {
    y_ = y;
    for (std::size_t i = 0; i < count(); ++i) {
      depths_[i] = bands_[i].depths(y) + x;
      texels_[i] = bands_[i].texels(y) + x;
      depth_of_row_[i] = sources_[i].depth[1] * static_cast<float>(y) + sources_[i].depth[2];
    }
    survey(x, groups);
    if (wanted.color) keep_outlines(x, groups);
    for (std::size_t i = 0; i < count(); ++i) sample(i, groups);
    Rgba8* const pixels = wanted.color ? view_.color.row(y).data() + x : nullptr;
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Ints best = load<Ints>(&span_.first[at]);
      const Ints colors = span_.is_contested[g] ? mixture(at, best) : first_colors(at);
      const int count = std::min(kLanes, view_.width - (x + at));
      if (wanted.color) write_colors(pixels + at, count, colors, load<Ints>(&span_.shown[at]));
      if (wanted.depth) write_depths(x, at, count, best);
    }
  }

  /// Of all that was merged.
  const OutlineBits& outlines() const { return outlines_; }

 private:
  std::size_t count() const { return kCount ? kCount : sources_.size(); }

  static float outline_of(std::span<const MergeSource> sources) {
    float coarsest = 0;
    for (const MergeSource& source : sources) coarsest = std::max(coarsest, inverse_step(source.noise));
    return kOutlineSteps * coarsest;
  }

  // Finds what each camera's fragments would be worth.
  void survey(int x, int groups) {
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Floats w[kMostCameras];
      Floats nearest = w[0] = load<Floats>(depths_[0] + at);
      Ints first{}, overlap{}, shown = nearest > empty_;
      for (std::size_t i = 1; i < count(); ++i) {
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
      if (bits(overlap)) {
        span_.is_contested[g] = weigh(x, at, w);
      } else {
        span_.is_contested[g] = false;
        for (std::size_t i = 0; i < count(); ++i) {
          const Ints is_first = shown & (first == static_cast<std::int32_t>(i));
          store(&span_.cameras[i].worth_per_cosine[at], is_first ? all(1.0F) : Floats{});
        }
      }
    }
  }

  void keep_outlines(int x, int groups) {
    // Rows of a band go on for a group of pixels beyond the view.
    const int end = groups * kLanes;
    span_.nearest[end] = depths_[0][end];
    for (std::size_t i = 1; i < count(); ++i)
      span_.nearest[end] = std::max(span_.nearest[end], depths_[i][end]);
    std::uint8_t* const outlines = outlines_.row(y_ - bands_[0].top()).data() + x / kLanes;
    for (int g = 0; g < groups; ++g) {
      const float* const nearest = &span_.nearest[g * kLanes];
      outlines[g] = find_outlines(load<Floats>(nearest), load<Floats>(nearest + 1), empty_, outline_);
    }
  }

  Floats source_depth(std::size_t i, int x, const Floats& z) const {
    const Eigen::Vector4f& d = sources_[i].depth;
    const Floats pixel_x = ramp() + static_cast<float>(x);
    return z * (d[0] * pixel_x + depth_of_row_[i]) + d[3];
  }

  // fragment_worth() of merge_rules.h before its cosine and up to a factor, for eight pixels of every camera.
  // Returns whether any but the nearest counts.
  bool weigh(int x, int at, const Floats (&w)[kMostCameras]) {
    Floats z[kMostCameras], noise[kMostCameras], uncertainty[kMostCameras];
    Floats nearest = w[0], nearest_z{}, nearest_uncertainty{};
    for (std::size_t i = 0; i < count(); ++i) {
      z[i] = 1.0F / w[i];
      const Floats source_z = source_depth(i, x + at, z[i]);
      noise[i] = noise_per_square_[i] * (source_z * source_z);
      uncertainty[i] = noise[i] + sources_[i].calibration_error_m;
      nearest_z = i == 0 ? z[i] : smaller(z[i], nearest_z);
      nearest_uncertainty = i == 0 || w[i] > nearest ? uncertainty[i] : nearest_uncertainty;
      nearest = larger(w[i], nearest);
    }
    Ints rivals{}, counting{};
    for (std::size_t i = 0; i < count(); ++i) {
      const Floats range = uncertainty[i] + nearest_uncertainty;
      const Floats room = range - (z[i] - nearest_z);     // that it may still lie further behind
      const Floats fading = smaller(room + room, range);  // times the range
      const Ints counts = (w[i] > empty_) & (room > 0);
      rivals |= counting & counts;
      counting |= counts;
      store(&span_.cameras[i].worth_per_cosine[at], counts ? fading / (noise[i] * range) : Floats{});
    }
    return bits(rivals) != 0;
  }

  // Samples a camera's texture where it counts.
  void sample(std::size_t i, int groups) {
    CameraSpan& camera = span_.cameras[i];
    const TextureSampler texture(*sources_[i].texture);
    const std::uint32_t* const texels = texels_[i];
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      const Ints counts = load<Floats>(&camera.worth_per_cosine[at]) > 0;
      if (!bits(counts)) continue;
      // The other lanes take the first texel, which is always at hand.
      const Ints colors = texture.at(counts & load<Ints>(texels + at));
      store(&camera.colors[at],
            sources_[i].opacity_256 == 256 ? colors : faded(colors, sources_[i].opacity_256));
    }
  }

  // Red, green and blue times the opacity; alpha as it is.
  static Ints faded(const Ints& colors, int opacity_256) {
    const auto times = [&](const Words& channels) {
      return (channels * static_cast<std::uint16_t>(opacity_256) + kHalf) >> 8;
    };
    const Ints rb = reinterpret_cast<Ints>(times(red_blue(colors)));
    const Ints g = reinterpret_cast<Ints>(times(reinterpret_cast<Words>(colors & 0xFF00) >> 8)) << 8;
    return rb | g | (colors & static_cast<std::int32_t>(0xFF000000U));
  }

  // The colours where no two cameras' fragments rival.
  Ints first_colors(int at) const {
    Ints colors{};
    for (std::size_t i = 0; i < count(); ++i) {
      const CameraSpan& camera = span_.cameras[i];
      colors |= (load<Floats>(&camera.worth_per_cosine[at]) > 0) & load<Ints>(&camera.colors[at]);
    }
    return colors;
  }

  static Floats alpha(const Ints& colors) {
    return as_floats(reinterpret_cast<Ints>(reinterpret_cast<UnsignedInts>(colors) >> 24));
  }
  static Words red_blue(const Ints& colors) { return reinterpret_cast<Words>(colors & 0x00FF00FF); }
  static Words green_alpha(const Ints& colors) { return reinterpret_cast<Words>(colors) >> 8; }

  // blend_weight() of merge_rules.h for every camera, and the sum of their colours. `best` becomes the camera
  // worth most.
  Ints mixture(int at, Ints& best) const {
    const auto worth_of = [&](std::size_t i, const Ints& colors) {
      return alpha(colors) * load<Floats>(&span_.cameras[i].worth_per_cosine[at]);
    };
    // The best so far, and what had to make room for it.
    Ints best_colors = load<Ints>(&span_.cameras[0].colors[at]), other_colors[kMostCameras];
    Floats best_worth = worth_of(0, best_colors), other_worth[kMostCameras];
    best = Ints{};
    for (std::size_t i = 1; i < count(); ++i) {
      const Ints colors = load<Ints>(&span_.cameras[i].colors[at]);
      const Floats worth = worth_of(i, colors);
      const Ints is_better = worth > best_worth;
      best = is_better ? all(static_cast<std::int32_t>(i)) : best;
      other_colors[i] = is_better ? best_colors : colors;
      best_colors = is_better ? colors : best_colors;
      other_worth[i] = smaller(worth, best_worth);
      best_worth = larger(worth, best_worth);
    }
    const Floats least_worth = kTieRatio * best_worth;
    Floats sum = (best_worth - least_worth) + kNothing;
    for (std::size_t i = 1; i < count(); ++i) {
      other_worth[i] = larger(other_worth[i] - least_worth, Floats{});
      sum += other_worth[i];
    }
    // Shares in 256ths, of what a colour differs from the best one's: what rounding leaves is so the best
    // one's. Every product is taken modulo 2^16, and their sum is a colour again.
    const Floats per_sum = 256.0F / sum;
    const Words best_rb = red_blue(best_colors), best_ga = green_alpha(best_colors);
    Words rb = (best_rb << 8) + kHalf, ga = (best_ga << 8) + kHalf;
    for (std::size_t i = 1; i < count(); ++i) {
      const Ints in_256ths = truncated(other_worth[i] * per_sum);
      const auto share = reinterpret_cast<Words>(in_256ths | in_256ths << 16);
      rb += (red_blue(other_colors[i]) - best_rb) * share;
      ga += (green_alpha(other_colors[i]) - best_ga) * share;
    }
    return reinterpret_cast<Ints>(rb >> 8) |
           (reinterpret_cast<Ints>(ga) & static_cast<std::int32_t>(0xFF00FF00U));
  }

  static void write_colors(Rgba8* to, int count, const Ints& colors, const Ints& shown) {
    const Ints pixels = (colors | static_cast<std::int32_t>(0xFF000000U)) & shown;
    static_assert(sizeof(Rgba8) * kLanes == sizeof pixels);
    std::memcpy(static_cast<void*>(to), &pixels, count == kLanes ? sizeof pixels : count * sizeof *to);
  }

  // Of the span at x in the view.
  void write_depths(int x, int at, int count, const Ints& best) {
    for (int lane = 0; lane < count; ++lane) {
      const int here = x + at + lane, camera = best[lane];
      const bool shown = span_.shown[at + lane] != 0;
      view_.camera(here, y_) = shown ? static_cast<std::uint8_t>(camera) : kNoCamera;
      if (!shown) {
        view_.depth_m(here, y_) = view_.quality(here, y_) = 0;
        continue;
      }
      const float z = 1.0F / depths_[camera][at + lane];
      const float source_z = source_depth(camera, here, all(z))[0];
      view_.depth_m(here, y_) = z;
      view_.quality(here, y_) =
          precision(sources_[camera].noise) *
          (kPerAlpha * static_cast<float>(span_.cameras[camera].colors[at + lane] >> 24) /
           (source_z * source_z));
    }
  }

  std::span<const MergeSource> sources_;
  std::span<const Band> bands_;
  float empty_;
  int y_ = 0;
  const float* depths_[kMostCameras];  // of the span
  const std::uint32_t* texels_[kMostCameras];
  float depth_of_row_[kMostCameras];      // the part of MergeSource::depth that is the row's
  float noise_per_square_[kMostCameras];  // uncertainty_per_square() of each
  MergedView& view_;
  float outline_;  // difference in inverse depth at an outline
  OutlineBits outlines_;
  Span span_;
};

}  // namespace

MergeSource merge_source(const CameraView& camera, const VirtualCamera& eye, const Texture& texture) {
  const Rigid3 camera_from_eye = camera.world_from_camera.inverse() * eye.world_from_eye;
  const Eigen::Vector3d row = camera_from_eye.rotation.row(2);
  const double a = row.x() / eye.lens.fx, b = row.y() / eye.lens.fy;
  MergeSource source;
  source.texture = &texture;
  source.depth =
      Eigen::Vector4d(a, b, row.z() - a * eye.lens.cx - b * eye.lens.cy, camera_from_eye.translation.z())
          .cast<float>();
  source.calibration_error_m = static_cast<float>(camera.calibration_error_m);
  source.noise = camera.noise;
  if (camera.opacity < 1) source.opacity_256 = std::min(static_cast<int>(256 * camera.opacity + 0.5F), 255);
  return source;
}

namespace {

template <std::size_t kCount>
void merge_spans(std::span<const MergeSource> sources, std::span<const Band> bands, HostPixels wanted,
                 MergedView& view) {
  SpanMerge<kCount> merge(sources, bands, view);
  // Down before across: the next row of a span reads nearly the same texels again.
  for (int x = 0; x < view.width; x += kSpan) {
    const int groups = (std::min(kSpan, view.width - x) + kLanes - 1) / kLanes;
    for (int y = bands[0].top(); y < bands[0].top() + bands[0].rows(); ++y) merge.run(x, y, groups, wanted);
  }
  if (wanted.color) soften_outlines(merge.outlines(), bands[0].top(), view);
}

}  // namespace

void merge_band(std::span<const MergeSource> sources, std::span<const Band> bands, HostPixels wanted,
                MergedView& view) {
  assert(!sources.empty() && sources.size() <= kMostCameras && sources.size() == bands.size());
  switch (sources.size()) {
    case 1:
      return merge_spans<1>(sources, bands, wanted, view);
    case 2:
      return merge_spans<2>(sources, bands, wanted, view);
    default:
      return merge_spans<0>(sources, bands, wanted, view);
  }
}

}  // namespace copresence::renderer
