#include "render_client/renderer/band_merge.h"

#include <cassert>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/texture_sampling.h"

namespace copresence::renderer {
namespace {

constexpr std::int32_t kFraction = kTexelSteps - 1;
constexpr int kFractionBits = 4;
static_assert(1 << kFractionBits == kTexelSteps);
constexpr std::uint32_t kOpaque = 0xFF000000U;
constexpr float kPerAlpha = 1.0F / 255;

Ints texels_at(const Band& band, int y, int x) {
  return load<Ints>(band.texels(y) + x);
}

Floats source_depths(const MergeSource& source, const Floats& x, float y, const Floats& z) {
  return z * (source.depth[0] * x + (source.depth[1] * y + source.depth[2])) + source.depth[3];
}

// Eight neighbouring pixels of the view on their way through the merge.
struct Group {
  unsigned shown = 0;    // bit per pixel
  unsigned blended = 0;  // of them, those whose colour has several cameras' share
  Ints best{};           // camera
  Ints texel{};          // its texture coordinate
  Floats quality{};      // its quality index; only where asked for or several cameras meet
  Floats depth{};        // inverse
  Floats sum{};          // of the weights
  Floats weight[kMostCameras];
};

class RowMerge {
 public:
  RowMerge(std::span<const MergeSource> sources, std::span<const Band> bands, int y, HostPixels wanted)
      : sources_(sources), bands_(bands), y_(y), wanted_(wanted) {
    for (std::size_t i = 0; i < bands.size(); ++i) depths_[i] = bands[i].depths(y);
  }

  /// What the eight pixels from x on show.
  void look(int x, Group& group) const {
    const float empty = bands_[0].empty();
    unsigned overlapping = 0;
    Floats nearest = all(empty);
    Ints first{};  // the nearest fragment's camera
    group.shown = 0;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Floats w = load<Floats>(depths_[i] + x);
      const unsigned there = bits(w > empty);
      if (there == 0) continue;
      overlapping |= group.shown & there;
      group.shown |= there;
      const Ints nearer = w > nearest;
      first = nearer ? all(static_cast<std::int32_t>(i)) : first;
      nearest = nearer ? w : nearest;
    }
    group.blended = 0;
    if (group.shown == 0) return;
    group.best = first;
    group.depth = nearest;
    if (overlapping != 0 || wanted_.depth) {
      weigh(x, nearest, first, group);
    } else {
      group.texel = texels_of(first, x);
    }
  }

  void color(int x, const Group& group, std::uint32_t* out) const {
    SamplePoints points;
    locate(group.best, group.texel, group.shown, points);
    sample(points, out);
    for (int lane = 0; lane < kLanes; ++lane) {
      out[lane] = group.shown >> lane & 1 ? out[lane] | kOpaque : 0;
    }
    if (group.blended) blend(x, group, out);
  }

 private:
  Ints texels_of(const Ints& camera, int x) const {
    Ints texel = texels_at(bands_[0], y_, x);
    for (std::size_t i = 1; i < sources_.size(); ++i) {
      const Ints won = camera == static_cast<std::int32_t>(i);
      if (bits(won)) texel = won ? texels_at(bands_[i], y_, x) : texel;
    }
    return texel;
  }

  // cos(theta) of the pixels nearest to the texture coordinates, with what being filled costs.
  Floats cosines(const MergeSource& source, const Ints& texel, unsigned lanes) const {
    const Texture& texture = *source.texture;
    const Ints half = all(std::int32_t{kTexelSteps / 2});
    const Ints u = ((texel & 0xFFFF) + half) >> kFractionBits;
    const Ints v = ((texel >> 16 & 0xFFFF) + half) >> kFractionBits;
    const Ints index = v * texture.width() + u;
    Ints alpha{};
    for (int lane = 0; lane < kLanes; ++lane) {
      if (lanes >> lane & 1) alpha[lane] = static_cast<std::int32_t>(texture.data()[index[lane]] >> 24);
    }
    return as_floats(alpha) * kPerAlpha;
  }

  // The rules of merge_rules.h, for eight pixels.
  void weigh(int x, const Floats& nearest, const Ints& first, Group& group) const {
    const Floats pixel_x = ramp() + static_cast<float>(x);
    const auto pixel_y = static_cast<float>(y_);
    const float empty = bands_[0].empty();
    const Floats nearest_z = 1.0F / nearest;
    Floats first_source_z{}, first_error{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints is_first = first == static_cast<std::int32_t>(i);
      const Floats source_z = source_depths(sources_[i], pixel_x, pixel_y, nearest_z);
      first_source_z = is_first ? source_z : first_source_z;
      first_error = is_first ? all(sources_[i].calibration_error_m) : first_error;
    }
    Floats best_worth{};
    Floats worth[kMostCameras];
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Floats w = load<Floats>(depths_[i] + x);
      const Ints there = w > empty;
      worth[i] = Floats{};
      if (bits(there) == 0) continue;
      const Floats z = 1.0F / w;
      const Floats source_z = source_depths(sources_[i], pixel_x, pixel_y, z);
      const Floats range =
          kRangeSigmas * 0.5F * kStepInverse * (source_z * source_z + first_source_z * first_source_z) +
          first_error + sources_[i].calibration_error_m;
      const Floats fade = smaller(larger(2.0F - 2.0F * (z - nearest_z) / range, Floats{}), all(1.0F));
      const Ints counts = there & (fade > 0);
      const unsigned counting = bits(counts);
      if (counting == 0) continue;
      const Ints texel = texels_at(bands_[i], y_, x);
      const Floats quality = cosines(sources_[i], texel, counting) / (source_z * source_z);
      worth[i] = counts ? quality * fade : Floats{};
      const Ints better = worth[i] > best_worth;
      best_worth = better ? worth[i] : best_worth;
      group.best = better ? all(static_cast<std::int32_t>(i)) : group.best;
      group.quality = better ? quality : group.quality;
      group.texel = better ? texel : group.texel;
      group.depth = better ? w : group.depth;
    }
    group.sum = Floats{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Floats share = (worth[i] - kTieRatio * best_worth) / ((1.0F - kTieRatio) * best_worth);
      group.weight[i] = smaller(larger(share, Floats{}), all(1.0F));
      group.sum += group.weight[i];
    }
    group.blended = bits(group.sum > 1.0F) & group.shown;
  }

  void locate(const Ints& camera, const Ints& texel, unsigned lanes, SamplePoints& points) const {
    const Ints u = texel & 0xFFFF;
    const Ints v = texel >> 16 & 0xFFFF;
    store(points.across.data(), u & kFraction);
    store(points.down.data(), v & kFraction);
    for (int lane = 0; lane < kLanes; ++lane) {
      const bool shown = lanes >> lane & 1;
      const Texture& texture = *sources_[shown ? camera[lane] : 0].texture;
      points.row[lane] = texture.width();
      points.texel[lane] =
          texture.data() + (shown ? static_cast<std::ptrdiff_t>(v[lane] >> kFractionBits) * texture.width() +
                                        (u[lane] >> kFractionBits)
                                  : 0);
    }
  }

  void blend(int x, const Group& group, std::uint32_t* out) const {
    Floats r{}, g{}, b{};
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Ints counts = group.weight[i] > 0;
      const unsigned lanes = bits(counts) & group.blended;
      if (lanes == 0) continue;
      SamplePoints points;
      locate(all(static_cast<std::int32_t>(i)), texels_at(bands_[i], y_, x), lanes, points);
      alignas(32) std::uint32_t colors[kLanes];
      sample(points, colors);
      const Ints c = load<Ints>(colors);
      const Floats share = counts ? group.weight[i] / group.sum : Floats{};
      r += share * as_floats(c & 0xFF);
      g += share * as_floats(c >> 8 & 0xFF);
      b += share * as_floats(c >> 16 & 0xFF);
    }
    const auto byte = [](const Floats& v) { return truncated(v + 0.5F); };
    const Ints mixed = byte(r) | byte(g) << 8 | byte(b) << 16;
    for (int lane = 0; lane < kLanes; ++lane) {
      if (group.blended >> lane & 1) out[lane] = static_cast<std::uint32_t>(mixed[lane]) | kOpaque;
    }
  }

  std::span<const MergeSource> sources_;
  std::span<const Band> bands_;
  int y_;
  HostPixels wanted_;
  const float* depths_[kMostCameras];
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

void merge_row(std::span<const MergeSource> sources, std::span<const Band> bands, int y, HostPixels wanted,
               MergedView& view) {
  assert(!sources.empty() && sources.size() <= kMostCameras && sources.size() == bands.size());
  static_assert(sizeof(Rgba8) == sizeof(std::uint32_t));
  const RowMerge merge(sources, bands, y, wanted);
  Group group;
  for (int x = 0; x < view.width; x += kLanes) {
    const int count = std::min(kLanes, view.width - x);
    merge.look(x, group);
    if (wanted.color) {
      alignas(32) std::uint32_t colors[kLanes] = {};
      if (group.shown) merge.color(x, group, colors);
      std::memcpy(view.color.row(y).data() + x, colors, sizeof(Rgba8) * count);
    }
    if (wanted.depth) {
      for (int lane = 0; lane < count; ++lane) {
        const bool shown = group.shown >> lane & 1;
        view.depth_m(x + lane, y) = shown ? 1.0F / group.depth[lane] : 0.0F;
        view.camera(x + lane, y) = shown ? static_cast<std::uint8_t>(group.best[lane]) : kNoCamera;
        view.quality(x + lane, y) = shown ? group.quality[lane] : 0.0F;
      }
    }
  }
}

}  // namespace copresence::renderer
