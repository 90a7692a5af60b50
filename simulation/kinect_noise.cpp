#include "simulation/kinect_noise.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "simulation/blob_noise.h"
#include "simulation/hash_noise.h"

namespace copresence::simulation {
namespace {

constexpr float kFixedError = 0.34f, kFrameError = 0.28f;  // standard deviations, in levels
constexpr float kBeside = 0.45f;                           // standard deviation of the lateral error, pixels
constexpr float kNeededReturn = 0.115f;                    // of infrared / z^2 weighting, see expose()
constexpr int kBlindColumns = 8;                           // of 640
constexpr float kLevels = static_cast<float>(kLevelConstant);

float to_value(float level, DepthUnit unit) {
  const float per_metre = unit == DepthUnit::kMillimetre ? 1000.0f : 10000.0f;
  return std::floor(kLevels * per_metre / level + 0.5f);
}

constexpr float kFirstLevel = 71, kLastLevel = 702;  // those between kFarthestDepth and kNearestDepth
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

KinectNoise::KinectNoise(const CameraModel& model, DepthUnit unit, std::uint32_t seed, std::uint32_t camera)
    : unit_(unit), seed_(hash(seed, camera, 0xD5)) {
  const int width = model.width, height = model.height;
  for (Image<float>* image : {&pattern_, &strength_needed_, &rivals_fixed_}) image->resize(width, height);

  // Fine bumps and a slow bend.
  Image<float> fine(width, height);
  fill_blob_noise(5, hash(seed_, 1), fine);
  fill_blob_noise(48, hash(seed_, 2), pattern_);
  for (std::size_t i = 0; i < pattern_.pixels().size(); ++i) {
    pattern_.data()[i] = kFixedError * (0.75f * fine.data()[i] + 0.66f * pattern_.data()[i]);
  }
  fill_blob_noise(6, hash(seed_, 3), strength_needed_);
  fill_blob_noise(7, hash(seed_, 4), rivals_fixed_);
  for (float& needed : strength_needed_.pixels()) needed = kNeededReturn * (1 + 0.35f * needed);
  drowning_ = Image<float>(width, height, std::numeric_limits<float>::max());
}

void KinectNoise::set_interference(const Image<float>& light) {
  assert(same_shape(light, drowning_));
  for (std::size_t i = 0; i < light.pixels().size(); ++i) {
    const float rival = light.data()[i];
    drowning_.data()[i] = rival > 0 ? 3.0f - 0.9f * std::min(rival, 1.5f) - 0.8f * rivals_fixed_.data()[i]
                                    : std::numeric_limits<float>::max();
  }
}

void KinectNoise::expose(const DotImage& dots, std::uint64_t frame, std::span<std::uint16_t> depth) {
  assert(same_shape(dots, pattern_) && depth.size() == dots.pixels().size());
  const int width = dots.width(), height = dots.height();
  const std::uint32_t frame_seed =
      hash(seed_, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32));
  BlobRows errors(3, hash(frame_seed, 1), width), besides_x(4, hash(frame_seed, 2), width),
      besides_y(4, hash(frame_seed, 3), width), lucks(5, hash(frame_seed, 4), width),
      all_rivals(7, hash(frame_seed, 5), width);

  std::vector<std::uint32_t> row_from(static_cast<std::size_t>(width));  // which pixel's dots each takes
  std::vector<Dots> row_taken(row_from.size());                          // and these
  std::uint32_t* __restrict from = row_from.data();
  Dots* __restrict taken = row_taken.data();

  const float per_metre = unit_ == DepthUnit::kMillimetre ? 1000.0f : 10000.0f;
  const int blind_from = width - kBlindColumns * width / 640;
  for (int y = 0; y < height; ++y) {
    const BlobRow beside_x = besides_x.next();
    const BlobRow beside_y = besides_y.next();
    for (int x = 0; x < width; ++x) {
      const int dx = static_cast<int>(std::floor(kBeside * beside_x[x] + 0.5f));
      const int dy = static_cast<int>(std::floor(kBeside * beside_y[x] + 0.5f));
      const int from_x = std::min(std::max(x + dx, 0), width - 1);
      const int from_y = std::min(std::max(y + dy, 0), height - 1);
      from[x] = static_cast<std::uint32_t>(from_y * width + from_x);
    }
    // By itself: eight loads are quicker than one vector's gathering.
    const Dots* __restrict all = dots.data();
    for (int x = 0; x < width; ++x) taken[x] = all[from[x]];

    const float* __restrict pattern = pattern_.row(y).data();
    const float* __restrict needed = strength_needed_.row(y).data();
    const float* __restrict drowning = drowning_.row(y).data();
    const BlobRow error = errors.next();
    const BlobRow luck = lucks.next();
    const BlobRow rivals = all_rivals.next();
    std::uint16_t* __restrict out =
        depth.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (int x = 0; x < width; ++x) {
      const float level = std::floor(taken[x].level + pattern[x] + kFrameError * error[x] + 0.5f);
      const bool seen = (level >= kFirstLevel) & (level <= kLastLevel) &
                        (taken[x].light > needed[x] * (1 + 0.12f * luck[x])) &
                        (0.6f * rivals[x] <= drowning[x]);
      const float value = std::floor(kLevels * per_metre / std::max(level, 1.0f) + 0.5f);
      out[x] = static_cast<std::uint16_t>(static_cast<int>(seen ? value : 0.0f));
    }
    std::fill(out + blind_from, out + width, std::uint16_t{0});
  }
}

}  // namespace copresence::simulation
