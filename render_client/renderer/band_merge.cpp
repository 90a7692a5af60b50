#include "render_client/renderer/band_merge.h"

#include <algorithm>
#include <bit>
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
  bool is_weighed =
      false;              // several cameras' fragments may count; then quality, texels and weights are known
  bool is_mixed = false;  // some colour has several cameras' share; else best's counts alone
  Ints best;              // camera
  Floats depth;           // its, inverse
  Floats quality;         // its quality index; only where asked for
  Floats sum;             // of the weights
  Texels texels[kMostCameras];
  Floats weight[kMostCameras];
};

// One camera's fragments in a group.
struct Candidate {
  Floats w, z;      // inverse depth and depth, m, from the eye
  Floats source_z;  // m, in its own camera
  Floats range;     // m, that it may lie behind the nearest fragment
  Floats room;      // m, that are left of it
  Ints counts;
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
    group.is_weighed = group.is_mixed = false;
    group.best = first;
    group.depth = nearest;
    if (bits(overlap) || (quality_wanted_ && group.is_shown)) find_rivals(x, first, group);
  }

  // r, g, b, a of the eight pixels. Requires that something is shown.
  Ints color(int x, const Group& group) const {
    const Ints opaque = all(static_cast<std::int32_t>(0xFF000000U)) & group.shown;
    return (group.is_mixed ? mixture(group) : best_colors(x, group)) | opaque;
  }

 private:
  // The texels of one camera's fragments. Only the lanes that count matter: the others take one of theirs, so that all
  // lie close together.
  Texels fetch_counting(std::size_t i, int x, const Ints& counts) const {
    const Ints texels = load<Ints>(texels_[i] + x);
    const int lane = std::countr_zero(bits(counts));
    return fetch(*sources_[i].texture, counts ? texels : all(texels[lane]));
  }

  Ints best_colors(int x, const Group& group) const {
    Ints colors{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints won = (group.best == static_cast<std::int32_t>(i)) & group.shown;
      if (bits(won)) {
        colors |= won & bilinear(group.is_weighed ? group.texels[i] : fetch_counting(i, x, won));
      }
    }
    return colors & 0x00FFFFFF;
  }

  Ints mixture(const Group& group) const {
    // Shares in 256ths that add up to 1: what rounding leaves is the best one's. Two channels are added up side
    // by side, 16 bits each.
    const Floats per_sum = 256.0F / group.sum;
    Ints red_blue{}, green{}, left = all(256);
    const auto add = [&](const Ints& colors, const Ints& share) {
      red_blue += (colors & 0x00FF00FF) * share;
      green += (colors >> 8 & 0xFF) * share;
    };
    Ints best_colors{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints counts = (group.weight[i] > 0) & group.shown;
      if (!bits(counts)) continue;
      const Ints colors = bilinear(group.texels[i]);
      const Ints is_best = group.best == static_cast<std::int32_t>(i);
      best_colors = is_best ? colors : best_colors;
      const Ints share = counts & ~is_best & truncated(group.weight[i] * per_sum);
      left -= share;
      add(colors, share);
    }
    add(best_colors, left);
    return ((red_blue + 0x00800080) >> 8 & 0x00FF00FF) | ((green + 0x80) & 0xFF00);
  }

  Floats source_depth(std::size_t i, const Floats& x, const Floats& z) const {
    const Eigen::Vector4f& d = sources_[i].depth;
    return z * (d[0] * x + (d[1] * y_ + d[2])) + d[3];
  }

  // Where another camera's fragment lies within the uncertainty range of the nearest, they are weighed;
  // elsewhere the nearest is all that counts.
  void find_rivals(int x, const Ints& first, Group& group) const {
    const Floats pixel_x = ramp() + static_cast<float>(x);
    Candidate candidates[kMostCameras];
    Floats nearest_z = all(1.0F / empty_), first_z{}, first_error{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      Candidate& c = candidates[i];
      c.w = load<Floats>(depths_[i] + x);
      c.z = 1.0F / c.w;
      c.source_z = source_depth(i, pixel_x, c.z);
      const Ints is_first = first == static_cast<std::int32_t>(i);
      nearest_z = smaller(c.z, nearest_z);
      first_z = is_first ? c.source_z : first_z;
      first_error = is_first ? all(sources_[i].calibration_error_m) : first_error;
    }
    Ints rivals{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      Candidate& c = candidates[i];
      c.range = kRangeSigmas * 0.5F * kStepInverse * (c.source_z * c.source_z + first_z * first_z) +
                first_error + sources_[i].calibration_error_m;
      c.room = c.range - (c.z - nearest_z);
      c.counts = (c.w > empty_) & (c.room > 0);
      rivals |= c.counts & (first != static_cast<std::int32_t>(i));
    }
    if (bits(rivals) || quality_wanted_) weigh(x, candidates, group);
  }

  // The rules of merge_rules.h, for eight pixels: fragment_worth() of every camera, then blend_weight().
  void weigh(int x, const Candidate* candidates, Group& group) const {
    group.is_weighed = true;
    Floats best_worth{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Candidate& c = candidates[i];
      group.weight[i] = Floats{};
      if (!bits(c.counts)) continue;
      group.texels[i] = fetch_counting(i, x, c.counts);
      const Ints alpha = nearest(group.texels[i]) >> 24 & 0xFF;
      const Floats cosine = as_floats(alpha) * kPerAlpha;
      const Floats squared = c.source_z * c.source_z;
      const Floats fading = smaller(c.room + c.room, c.range);  // times the range
      const Floats worth = c.counts ? cosine * fading / (squared * c.range) : Floats{};
      const Ints better = worth > best_worth;
      best_worth = larger(worth, best_worth);
      group.best = better ? all(static_cast<std::int32_t>(i)) : group.best;
      if (quality_wanted_) group.quality = better ? cosine / squared : group.quality;
      group.depth = better ? c.w : group.depth;
      group.weight[i] = worth;
    }
    group.sum = Floats{};
    const Floats per_worth = 1.0F / ((1.0F - kTieRatio) * best_worth);
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      group.weight[i] = clamped((group.weight[i] - kTieRatio * best_worth) * per_worth);
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
