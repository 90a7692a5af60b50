#include "render_client/renderer/band_merge.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/texture_sampling.h"

namespace copresence::renderer {
namespace {

constexpr float kPerAlpha = 1.0F / 255;

// A row is merged in spans of this many pixels, and a span in three short passes: one long loop body would wait for
// its own results, since a processor looks only a few hundred instructions ahead.
constexpr int kSpan = 64;
constexpr int kGroups = kSpan / kLanes;

// What the passes tell each other about one camera's fragments.
struct CameraSpan {
  alignas(32) std::array<float, kSpan> worth_per_cosine;  // 0: does not count; 1 where no other camera's does
  alignas(32) std::array<std::uint32_t, kSpan> colors;    // where it counts; alpha as in Texture
};

struct Span {
  std::array<CameraSpan, kMostCameras> cameras;
  alignas(32) std::array<std::int32_t, kSpan> first;  // the nearest fragment's camera
  alignas(32) std::array<std::int32_t, kSpan> shown;  // all bits set where there is anything
  std::array<bool, kGroups> is_contested;             // several cameras may count somewhere in the group
};

// kCount: the number of cameras where the compiler is to know it, 0 where it is not.
template <std::size_t kCount>
class SpanMerge {
 public:
  SpanMerge(std::span<const MergeSource> sources, std::span<const Band> bands, MergedView& view)
      : sources_(sources), bands_(bands), empty_(bands[0].empty()), view_(view) {}

  // Merges `groups` groups of eight pixels from (x, y) on. The last may reach beyond the view.
  void run(int x, int y, int groups, HostPixels wanted) {
    y_ = y;
    for (std::size_t i = 0; i < count(); ++i) {
      depths_[i] = bands_[i].depths(y) + x;
      texels_[i] = bands_[i].texels(y) + x;
    }
    survey(x, groups);
    for (std::size_t i = 0; i < count(); ++i) sample(i, groups);
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Ints best = load<Ints>(&span_.first[at]);
      const Ints colors = span_.is_contested[g] ? mixture(at, best) : first_colors(at);
      const int count = std::min(kLanes, view_.width - (x + at));
      if (wanted.color) write_colors(x + at, count, colors, load<Ints>(&span_.shown[at]));
      if (wanted.depth) write_depths(x, at, count, best);
    }
  }

 private:
  std::size_t count() const { return kCount ? kCount : sources_.size(); }

  // Finds what each camera's fragments would be worth.
  void survey(int x, int groups) {
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      Floats nearest = all(empty_);
      Ints first{}, overlap{}, shown{};
      for (std::size_t i = 0; i < count(); ++i) {
        const Floats w = load<Floats>(depths_[i] + at);
        const Ints there = w > empty_;
        overlap |= shown & there;
        shown |= there;
        first = w > nearest ? all(static_cast<std::int32_t>(i)) : first;
        nearest = larger(w, nearest);
      }
      store(&span_.first[at], first);
      store(&span_.shown[at], shown);
      if (bits(overlap)) {
        span_.is_contested[g] = weigh(x, at, first);
      } else {
        span_.is_contested[g] = false;
        for (std::size_t i = 0; i < count(); ++i) {
          const Ints is_first = shown & (first == static_cast<std::int32_t>(i));
          store(&span_.cameras[i].worth_per_cosine[at], is_first ? all(1.0F) : Floats{});
        }
      }
    }
  }

  Floats source_depth(std::size_t i, int x, const Floats& z) const {
    const Eigen::Vector4f& d = sources_[i].depth;
    const Floats pixel_x = ramp() + static_cast<float>(x);
    return z * (d[0] * pixel_x + (d[1] * static_cast<float>(y_) + d[2])) + d[3];
  }

  // fragment_worth() of merge_rules.h before its cosine, for eight pixels of every camera. Returns whether any but the
  // nearest counts.
  bool weigh(int x, int at, const Ints& first) {
    Floats depth[kMostCameras], source_z[kMostCameras];
    Floats nearest_z = all(1.0F / empty_), first_z{}, first_error{};
    for (std::size_t i = 0; i < count(); ++i) {
      depth[i] = 1.0F / load<Floats>(depths_[i] + at);
      source_z[i] = source_depth(i, x + at, depth[i]);
      nearest_z = smaller(depth[i], nearest_z);
      const Ints is_first = first == static_cast<std::int32_t>(i);
      first_z = is_first ? source_z[i] : first_z;
      first_error = is_first ? all(sources_[i].calibration_error_m) : first_error;
    }
    Ints rivals{};
    const Floats first_range = kRangeSigmas * 0.5F * kStepInverse * (first_z * first_z) + first_error;
    for (std::size_t i = 0; i < count(); ++i) {
      const Floats squared = source_z[i] * source_z[i];
      const Floats range =
          kRangeSigmas * 0.5F * kStepInverse * squared + (first_range + sources_[i].calibration_error_m);
      const Floats room = range - (depth[i] - nearest_z);  // that it may still lie further behind
      const Floats fading = smaller(room + room, range);   // times the range
      const Ints counts = (load<Floats>(depths_[i] + at) > empty_) & (room > 0);
      rivals |= counts & (first != static_cast<std::int32_t>(i));
      store(&span_.cameras[i].worth_per_cosine[at], counts ? fading / (squared * range) : Floats{});
    }
    return bits(rivals) != 0;
  }

  // Samples a camera's texture where it counts.
  void sample(std::size_t i, int groups) {
    CameraSpan& camera = span_.cameras[i];
    for (int g = 0; g < groups; ++g) {
      const int at = g * kLanes;
      const Ints counts = load<Floats>(&camera.worth_per_cosine[at]) > 0;
      if (!bits(counts)) continue;
      // The other lanes take the first texel, which is always at hand.
      store(&camera.colors[at], renderer::sample(*sources_[i].texture, counts & load<Ints>(texels_[i] + at)));
    }
  }

  // The colours where no two cameras' fragments rival.
  Ints first_colors(int at) const {
    Ints colors{};
    for (std::size_t i = 0; i < count(); ++i) {
      const CameraSpan& camera = span_.cameras[i];
      const Ints counts = load<Floats>(&camera.worth_per_cosine[at]) > 0;
      if (bits(counts)) colors |= counts & load<Ints>(&camera.colors[at]);
    }
    return colors;
  }

  static Floats cosine(const Ints& colors) { return as_floats(colors >> 24 & 0xFF) * kPerAlpha; }

  // blend_weight() of merge_rules.h for every camera, and the sum of their colours. `best` becomes the camera worth
  // most.
  Ints mixture(int at, Ints& best) const {
    Floats worth[kMostCameras];
    Floats best_worth{};
    for (std::size_t i = 0; i < count(); ++i) {
      const CameraSpan& camera = span_.cameras[i];
      const Floats per_cosine = load<Floats>(&camera.worth_per_cosine[at]);
      worth[i] = per_cosine > 0 ? cosine(load<Ints>(&camera.colors[at])) * per_cosine : Floats{};
      best = worth[i] > best_worth ? all(static_cast<std::int32_t>(i)) : best;
      best_worth = larger(worth[i], best_worth);
    }
    Floats sum{};
    for (std::size_t i = 0; i < count(); ++i) {
      worth[i] = larger(worth[i] - kTieRatio * best_worth, Floats{});
      sum += worth[i];
    }
    // Shares in 256ths that add up to 1: what rounding leaves is the best one's. Two channels are added up side by
    // side, 16 bits each.
    const Floats per_sum = 256.0F / sum;
    Ints red_blue = all(0x00800080), green = all(0x80), left = all(256), best_colors{};
    const auto add = [&](const Ints& colors, const Ints& share) {
      red_blue += (colors & 0x00FF00FF) * share;
      green += (colors >> 8 & 0xFF) * share;
    };
    for (std::size_t i = 0; i < count(); ++i) {
      const Ints colors = load<Ints>(&span_.cameras[i].colors[at]);
      const Ints is_best = best == static_cast<std::int32_t>(i);
      best_colors = is_best ? colors : best_colors;
      const Ints share = (worth[i] > 0) & ~is_best & truncated(worth[i] * per_sum);
      left -= share;
      add(colors, share);
    }
    add(best_colors, left);
    return (red_blue >> 8 & 0x00FF00FF) | (green & 0xFF00);
  }

  void write_colors(int x, int count, const Ints& colors, const Ints& shown) {
    static_assert(sizeof(Rgba8) == sizeof(std::uint32_t));
    const Ints pixels = (colors | static_cast<std::int32_t>(0xFF000000U)) & shown;
    auto* const to = reinterpret_cast<std::uint32_t*>(view_.color.row(y_).data()) + x;
    if (count == kLanes) {
      store(to, pixels);
    } else {
      for (int lane = 0; lane < count; ++lane) to[lane] = static_cast<std::uint32_t>(pixels[lane]);
    }
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
          cosine(all(static_cast<std::int32_t>(span_.cameras[camera].colors[at + lane])))[0] /
          (source_z * source_z);
    }
  }

  std::span<const MergeSource> sources_;
  std::span<const Band> bands_;
  float empty_;
  int y_ = 0;
  const float* depths_[kMostCameras];  // of the span
  const std::uint32_t* texels_[kMostCameras];
  MergedView& view_;
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
