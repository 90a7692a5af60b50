#include "simulation/sensor/kinect_depth.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "simulation/scene/noise.h"

namespace copresence::simulation {
namespace {

constexpr float kFixedError = 0.34f, kFrameError = 0.28f;  // Standard deviations, in levels.
constexpr float kLateralError = 0.45f;                     // Standard deviation, in pixels.
constexpr float kNeededIntensity = 0.115f;                 // Mean threshold of Dots::intensity.
constexpr int kBlindColumns = 8;                           // Per 640 columns.
constexpr float kLevels = static_cast<float>(kLevelConstant);
constexpr float kLeastDepth = 0.2f;  // In metres. Closer surfaces cast no shadow.

float to_value(float level, DepthUnit unit) {
  const float per_metre = unit == DepthUnit::kMillimetre ? 1000.0f : 10000.0f;
  return std::floor(kLevels * per_metre / level + 0.5f);
}

constexpr float kFirstLevel = 71, kLastLevel = 702;  // Between kFarthestDepth and kNearestDepth.
static_assert(kFirstLevel * kFarthestDepth >= kLevelConstant &&
              (kFirstLevel - 1) * kFarthestDepth < kLevelConstant);
static_assert(kLastLevel * kNearestDepth <= kLevelConstant &&
              (kLastLevel + 1) * kNearestDepth > kLevelConstant);

}  // namespace

std::vector<std::uint16_t> kinect_levels(DepthUnit unit) {
  std::vector<std::uint16_t> levels;
  for (float k = kLastLevel; k >= kFirstLevel; k -= 1) {
    const auto value = static_cast<std::uint16_t>(to_value(k, unit));
    if (levels.empty() || levels.back() != value) levels.push_back(value);
  }
  return levels;
}

// A surface at pixel column u and depth z is lit through column u - f b / z of the projector, where
// f is the focal length and b the baseline. In each projector column, only the nearest surface gets
// dots. Columns between neighbouring pixels of the same surface are filled.
void project_dots(const CameraModel& model, const TrueView& view, DotImage& dots) {
  assert(view.depth_m.width() == model.width && view.depth_m.height() == model.height);
  const auto shift = static_cast<float>(model.fx * kProjectorBaseline);
  const int margin = static_cast<int>(std::ceil(shift / kLeastDepth)) + 2;
  const int width = model.width;
  constexpr float kFar = 1e9f;
  const auto row_of = [&](auto value) { return std::vector(static_cast<std::size_t>(width), value); };
  std::vector<float> levels = row_of(0.0f), exact_columns = row_of(0.0f);
  std::vector<int> columns = row_of(0);  // The rounded-down exact_columns.
  std::vector<float> nearest(static_cast<std::size_t>(width + margin) + 2);
  dots.resize(width, model.height);
  float* __restrict level = levels.data();
  float* __restrict exact_column = exact_columns.data();
  int* __restrict column = columns.data();
  float* __restrict near = nearest.data();
  for (int y = 0; y < model.height; ++y) {
    const float* __restrict z = view.depth_m.row(y).data();
    const float* __restrict infrared = view.infrared.row(y).data();
    Dots* __restrict out = dots.row(y).data();
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
      const float inverse = 1 / std::max(z[x], kLeastDepth);
      const float exact = static_cast<float>(x + margin) - shift * inverse;
      exact_column[x] = exact;
      column[x] = static_cast<int>(exact);
      level[x] = static_cast<float>(kLevelConstant) * inverse;
    }
    std::fill(nearest.begin(), nearest.end(), kFar);
    for (int x = 0; x < width; ++x) {
      if (z[x] < kLeastDepth) continue;
      const int last = column[x];
      near[last] = std::min(near[last], z[x]);
      if (x == 0 || last - column[x - 1] <= 1) continue;
      if (exact_column[x] - exact_column[x - 1] <= 1 || std::abs(z[x] - z[x - 1]) >= 0.03f * z[x]) continue;
      for (int c = column[x - 1] + 1; c < last; ++c) near[c] = std::min(near[c], z[x]);
    }
#pragma GCC ivdep
    for (int x = 0; x < width; ++x) {
      out[x].level = near[column[x]] < z[x] * 0.96f ? 0.0f : level[x];
      out[x].intensity = infrared[x] * (1.25f - 0.09f * z[x]);
    }
  }
}

KinectNoise::KinectNoise(const CameraModel& model, DepthUnit unit, std::uint32_t seed, std::uint32_t camera)
    : unit_(unit), seed_(hash(seed, camera, 0xD5)) {
  const int width = model.width, height = model.height;
  for (Image<float>* image : {&pattern_, &needed_intensity_, &fixed_interference_})
    image->resize(width, height);

  // The fixed error is a sum of fine bumps and a slow bend.
  Image<float> fine(width, height);
  fill_blob_noise(5, hash(seed_, 1), fine);
  fill_blob_noise(48, hash(seed_, 2), pattern_);
  for (std::size_t i = 0; i < pattern_.pixels().size(); ++i) {
    pattern_.data()[i] = kFixedError * (0.75f * fine.data()[i] + 0.66f * pattern_.data()[i]);
  }
  fill_blob_noise(6, hash(seed_, 3), needed_intensity_);
  fill_blob_noise(7, hash(seed_, 4), fixed_interference_);
  for (float& needed : needed_intensity_.pixels()) needed = kNeededIntensity * (1 + 0.35f * needed);
  interference_threshold_ = Image<float>(width, height, std::numeric_limits<float>::max());
}

void KinectNoise::set_interference(const Image<float>& light) {
  assert(same_shape(light, interference_threshold_));
  for (std::size_t i = 0; i < light.pixels().size(); ++i) {
    const float others = light.data()[i];
    interference_threshold_.data()[i] =
        others > 0 ? 3.0f - 0.9f * std::min(others, 1.5f) - 0.8f * fixed_interference_.data()[i]
                   : std::numeric_limits<float>::max();
  }
}

void KinectNoise::add_noise(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth) {
  assert(same_shape(dots, pattern_) && depth.size() == dots.pixels().size());
  const int width = dots.width(), height = dots.height();
  const std::uint32_t frame_seed =
      hash(seed_, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32));
  BlobRows errors(3, hash(frame_seed, 1), width), shifts_x(4, hash(frame_seed, 2), width),
      shifts_y(4, hash(frame_seed, 3), width), gains(5, hash(frame_seed, 4), width),
      interferences(7, hash(frame_seed, 5), width);

  std::vector<std::uint32_t> row_from(
      static_cast<std::size_t>(width));          // Index of the source pixel of each pixel.
  std::vector<Dots> row_taken(row_from.size());  // Dots of the source pixels.
  std::uint32_t* __restrict from = row_from.data();
  Dots* __restrict taken = row_taken.data();

  const float per_metre = unit_ == DepthUnit::kMillimetre ? 1000.0f : 10000.0f;
  const int blind_from = width - kBlindColumns * width / 640;
  for (int y = 0; y < height; ++y) {
    const BlobRow shift_x = shifts_x.next();
    const BlobRow shift_y = shifts_y.next();
    for (int x = 0; x < width; ++x) {
      const int dx = static_cast<int>(std::floor(kLateralError * shift_x[x] + 0.5f));
      const int dy = static_cast<int>(std::floor(kLateralError * shift_y[x] + 0.5f));
      const int from_x = std::min(std::max(x + dx, 0), width - 1);
      const int from_y = std::min(std::max(y + dy, 0), height - 1);
      from[x] = static_cast<std::uint32_t>(from_y * width + from_x);
    }
    // This loop is separate, because eight scalar loads are faster than one gather instruction.
    const Dots* __restrict all = dots.data();
    for (int x = 0; x < width; ++x) taken[x] = all[from[x]];

    const float* __restrict pattern = pattern_.row(y).data();
    const float* __restrict needed = needed_intensity_.row(y).data();
    const float* __restrict threshold = interference_threshold_.row(y).data();
    const BlobRow error = errors.next();
    const BlobRow gain = gains.next();
    const BlobRow interference = interferences.next();
    std::uint16_t* __restrict out =
        depth.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (int x = 0; x < width; ++x) {
      const float level = std::floor(taken[x].level + pattern[x] + kFrameError * error[x] + 0.5f);
      // The conditions are integers, because && would keep the loop from becoming vector code.
      const int measured = int{level >= kFirstLevel} & int{level <= kLastLevel} &
                           int{taken[x].intensity > needed[x] * (1 + 0.12f * gain[x])} &
                           int{0.6f * interference[x] <= threshold[x]};
      const float value = std::floor(kLevels * per_metre / std::max(level, 1.0f) + 0.5f);
      out[x] = static_cast<std::uint16_t>(static_cast<int>(measured ? value : 0.0f));
    }
    std::fill(out + blind_from, out + width, std::uint16_t{0});
  }
}

}  // namespace copresence::simulation
