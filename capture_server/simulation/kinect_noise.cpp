#include "capture_server/simulation/kinect_noise.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "capture_server/simulation/blob_noise.h"
#include "capture_server/simulation/hash_noise.h"

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

const float kFirstLevel = std::ceil(kLevels / static_cast<float>(kFarthestDepth));
const float kLastLevel = std::floor(kLevels / static_cast<float>(kNearestDepth));

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
    : model_(model), unit_(unit), seed_(hash(seed, camera, 0xD5)) {
  const int width = model.width, height = model.height;
  pattern_ = Image<float>(width, height);
  strength_needed_ = Image<float>(width, height);
  interference_ = Image<float>(width, height, 0.0f);
  lit_ = Image<std::uint8_t>(width, height, 1);
  for (Image<float>* image : {&error_, &beside_x_, &beside_y_, &luck_, &rivals_, &rivals_fixed_})
    image->resize(width, height);

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
}

// Along a row a surface at pixel u and depth z lies in the projector's column u - f b / z; what is farther
// than the nearest surface of its column gets no dots. Between neighbouring pixels of one surface the columns
// are filled.
void KinectNoise::cast_shadow(const Image<float>& depth_m) {
  const auto shift = static_cast<float>(model_.fx * kProjectorBaseline);
  const int margin = static_cast<int>(std::ceil(shift / static_cast<float>(kNearestDepth))) + 2;
  const int columns = model_.width + margin;
  constexpr float kFar = 1e9f;
  for (int y = 0; y < model_.height; ++y) {
    const auto row = depth_m.row(y);
    nearest_.assign(static_cast<std::size_t>(columns) + 2, kFar);
    float column_before = 0, z_before = 0;
    for (int x = 0; x < model_.width; ++x) {
      const float z = row[static_cast<std::size_t>(x)];
      if (z < 0.2f) {
        z_before = 0;
        continue;
      }
      const float column = static_cast<float>(x) - shift / z + static_cast<float>(margin);
      const bool same_surface = z_before > 0 && std::abs(z - z_before) < 0.03f * z;
      if (column >= 0) {
        int first = static_cast<int>(column);
        if (same_surface && column > column_before && column_before >= 0) {
          first = std::min(static_cast<int>(column_before) + 1, first);
        }
        for (int c = first; c <= static_cast<int>(column); ++c) {
          nearest_[static_cast<std::size_t>(c)] = std::min(nearest_[static_cast<std::size_t>(c)], z);
        }
      }
      column_before = column;
      z_before = z;
    }
    auto lit = lit_.row(y);
    for (int x = 0; x < model_.width; ++x) {
      const float z = row[static_cast<std::size_t>(x)];
      const float column = static_cast<float>(x) - shift / std::max(z, 0.2f) + static_cast<float>(margin);
      const auto c = static_cast<std::size_t>(std::clamp(column, 0.0f, static_cast<float>(columns - 1)));
      lit[static_cast<std::size_t>(x)] = nearest_[c] < z * 0.96f ? 0 : 1;
    }
  }
}

void KinectNoise::expose(const TrueView& view, std::uint64_t frame, DepthImage& depth) {
  assert(view.depth_m.width() == model_.width && view.depth_m.height() == model_.height);
  const int width = model_.width, height = model_.height;
  depth.resize(width, height);
  cast_shadow(view.depth_m);
  const std::uint32_t frame_seed =
      hash(seed_, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(frame >> 32));
  fill_blob_noise(3, hash(frame_seed, 1), error_);
  fill_blob_noise(4, hash(frame_seed, 2), beside_x_);
  fill_blob_noise(4, hash(frame_seed, 3), beside_y_);
  fill_blob_noise(5, hash(frame_seed, 4), luck_);
  fill_blob_noise(7, hash(frame_seed, 5), rivals_);

  const float* true_depth = view.depth_m.data();
  const float* infrared = view.infrared.data();
  const std::uint8_t* lit = lit_.data();
  const float per_metre = unit_ == DepthUnit::kMillimetre ? 1000.0f : 10000.0f;
  const int blind_from = width - kBlindColumns * width / 640;
  for (int y = 0; y < height; ++y) {
    const auto start = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (int x = 0; x < width; ++x) {
      const std::size_t i = start + static_cast<std::size_t>(x);
      const int dx = static_cast<int>(std::floor(kBeside * beside_x_.data()[i] + 0.5f));
      const int dy = static_cast<int>(std::floor(kBeside * beside_y_.data()[i] + 0.5f));
      const int from_x = std::clamp(x + dx, 0, width - 1), from_y = std::clamp(y + dy, 0, height - 1);
      const int from = from_y * width + from_x;
      const float z = true_depth[from];
      const float level = std::floor(kLevels / std::max(z, 0.1f) + pattern_.data()[i] +
                                     kFrameError * error_.data()[i] + 0.5f);
      // Light that comes back falls with distance; automatic gain gives most of it back to what is far.
      const float back = infrared[from] * (1.25f - 0.09f * z);
      const float needed = strength_needed_.data()[i] * (1 + 0.12f * luck_.data()[i]);
      const bool drowned = 0.8f * rivals_fixed_.data()[i] + 0.6f * rivals_.data()[i] >
                               3.0f - 0.9f * std::min(interference_.data()[i], 1.5f) &&
                           interference_.data()[i] > 0;
      const bool seen = level >= kFirstLevel && level <= kLastLevel && back > needed && lit[from] != 0 &&
                        !drowned && x < blind_from;
      depth.data()[i] = seen ? static_cast<std::uint16_t>(std::floor(kLevels * per_metre / level + 0.5f))
                             : std::uint16_t{0};
    }
  }
}

}  // namespace copresence::simulation
