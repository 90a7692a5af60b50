#include "render_client/renderer/band_merge.h"

#include <algorithm>
#include <cassert>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/texture_sampling.h"

namespace copresence::renderer {
namespace {

constexpr float kPerAlpha = 1.0F / 255;

// Eight neighbouring pixels of the view on their way through the merge.
struct Group {
  Ints shown;             // all bits set where there is anything
  bool is_shown = false;  // anywhere
  bool is_mixed = false;  // some colour has several cameras' share; then the weights count, else best
  Ints best;              // camera
  Floats depth;           // its, inverse
  Floats quality;         // its quality index; only where asked for or where cameras overlap
  Floats sum;             // of the weights
  Floats weight[kMostCameras];
};

Floats clamped(const Floats& v) {
  return smaller(larger(v, Floats{}), all(1.0F));
}

class RowMerge {
 public:
  RowMerge(std::span<const MergeSource> sources, std::span<const Band> bands, int y, bool quality_wanted)
      : sources_(sources),
        empty_(bands[0].empty()),
        y_(static_cast<float>(y)),
        quality_wanted_(quality_wanted) {
    for (std::size_t i = 0; i < bands.size(); ++i) {
      depths_[i] = bands[i].depths(y);
      texels_[i] = bands[i].texels(y);
    }
  }

  // What the eight pixels from x on show.
  void look(int x, Group& group) const {
    Floats nearest = all(empty_);
    Ints first{};  // the nearest fragment's camera
    Ints overlap{}, shown{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Floats w = load<Floats>(depths_[i] + x);
      const Ints there = w > empty_;
      overlap |= shown & there;
      shown |= there;
      const Ints nearer = w > nearest;
      first = nearer ? all(static_cast<std::int32_t>(i)) : first;
      nearest = larger(w, nearest);
    }
    group.shown = shown;
    group.is_shown = bits(shown) != 0;
    group.is_mixed = false;
    group.best = first;
    group.depth = nearest;
    if (bits(overlap) || (quality_wanted_ && group.is_shown)) weigh(x, first, nearest, group);
  }

  // r, g, b, a of the eight pixels. Requires that something is shown.
  Ints color(int x, const Group& group) const {
    const Ints opaque = all(static_cast<std::int32_t>(0xFF000000U)) & group.shown;
    return (group.is_mixed ? mixture(x, group) : best_colors(x, group)) | opaque;
  }

 private:
  Ints best_colors(int x, const Group& group) const {
    Ints colors{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints won = (group.best == static_cast<std::int32_t>(i)) & group.shown;
      if (bits(won)) colors |= won & sample(*sources_[i].texture, won & load<Ints>(texels_[i] + x));
    }
    return colors & 0x00FFFFFF;
  }

  Ints mixture(int x, const Group& group) const {
    Floats r{}, g{}, b{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints counts = (group.weight[i] > 0) & group.shown;
      if (!bits(counts)) continue;
      const Ints colors = sample(*sources_[i].texture, counts & load<Ints>(texels_[i] + x));
      const Floats share = counts ? group.weight[i] / group.sum : Floats{};
      r += share * as_floats(colors & 0xFF);
      g += share * as_floats(colors >> 8 & 0xFF);
      b += share * as_floats(colors >> 16 & 0xFF);
    }
    return truncated(r + 0.5F) | truncated(g + 0.5F) << 8 | truncated(b + 0.5F) << 16;
  }

  Floats source_depth(std::size_t i, const Floats& x, const Floats& z) const {
    const Eigen::Vector4f& d = sources_[i].depth;
    return z * (d[0] * x + (d[1] * y_ + d[2])) + d[3];
  }

  // The rules of merge_rules.h, for eight pixels: fragment_worth() of every camera, then blend_weight().
  void weigh(int x, const Ints& first, const Floats& nearest, Group& group) const {
    const Floats pixel_x = ramp() + static_cast<float>(x);
    const Floats nearest_z = 1.0F / nearest;
    Floats first_z{}, first_error{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints is_first = first == static_cast<std::int32_t>(i);
      first_z = is_first ? source_depth(i, pixel_x, nearest_z) : first_z;
      first_error = is_first ? all(sources_[i].calibration_error_m) : first_error;
    }
    Floats best_worth{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      group.weight[i] = Floats{};
      const Floats w = load<Floats>(depths_[i] + x);
      const Ints there = w > empty_;
      if (!bits(there)) continue;
      const Floats z = 1.0F / w;
      const Floats source_z = source_depth(i, pixel_x, z);
      const Floats range = kRangeSigmas * 0.5F * kStepInverse * (source_z * source_z + first_z * first_z) +
                           first_error + sources_[i].calibration_error_m;
      const Floats fade = clamped(2.0F - 2.0F * (z - nearest_z) / range);
      const Ints counts = there & (fade > 0);
      if (!bits(counts)) continue;
      const Ints alpha =
          nearest_texels(*sources_[i].texture, counts & load<Ints>(texels_[i] + x)) >> 24 & 0xFF;
      const Floats quality = as_floats(alpha) * kPerAlpha / (source_z * source_z);
      const Floats worth = counts ? quality * fade : Floats{};
      const Ints better = worth > best_worth;
      best_worth = larger(worth, best_worth);
      group.best = better ? all(static_cast<std::int32_t>(i)) : group.best;
      group.quality = better ? quality : group.quality;
      group.depth = better ? w : group.depth;
      group.weight[i] = worth;
    }
    group.sum = Floats{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      group.weight[i] =
          clamped((group.weight[i] - kTieRatio * best_worth) / ((1.0F - kTieRatio) * best_worth));
      group.sum += group.weight[i];
    }
    group.is_mixed = bits((group.sum > 1.0F) & group.shown) != 0;
  }

  std::span<const MergeSource> sources_;
  float empty_;
  float y_;
  bool quality_wanted_;
  const float* depths_[kMostCameras];
  const std::uint32_t* texels_[kMostCameras];
};

void write_depths(const Group& group, int x, int y, int count, MergedView& view) {
  for (int lane = 0; lane < count; ++lane) {
    const bool shown = group.shown[lane];
    view.depth_m(x + lane, y) = shown ? 1.0F / group.depth[lane] : 0.0F;
    view.camera(x + lane, y) = shown ? static_cast<std::uint8_t>(group.best[lane]) : kNoCamera;
    view.quality(x + lane, y) = shown ? group.quality[lane] : 0.0F;
  }
}

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

void merge_row(std::span<const MergeSource> sources, std::span<const Band> bands, int y, HostPixels wanted,
               MergedView& view) {
  assert(!sources.empty() && sources.size() <= kMostCameras && sources.size() == bands.size());
  static_assert(sizeof(Rgba8) == sizeof(std::uint32_t));
  const RowMerge merge(sources, bands, y, wanted.depth);
  const std::span<Rgba8> row = wanted.color ? view.color.row(y) : std::span<Rgba8>{};
  auto* const colors = reinterpret_cast<std::uint32_t*>(row.data());
  Group group;
  int x = 0;
  for (; x + kLanes <= view.width; x += kLanes) {
    merge.look(x, group);
    if (colors) store(colors + x, group.is_shown ? merge.color(x, group) : Ints{});
    if (wanted.depth) write_depths(group, x, y, kLanes, view);
  }
  const int rest = view.width - x;
  if (rest == 0) return;
  merge.look(x, group);
  if (colors) {
    const Ints last = group.is_shown ? merge.color(x, group) : Ints{};
    for (int lane = 0; lane < rest; ++lane) colors[x + lane] = static_cast<std::uint32_t>(last[lane]);
  }
  if (wanted.depth) write_depths(group, x, y, rest, view);
}

}  // namespace copresence::renderer
