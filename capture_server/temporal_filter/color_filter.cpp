#include "capture_server/temporal_filter/color_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

namespace copresence::temporal_filter {
namespace {

constexpr int kMeanBits = 7;  // Fractional bits of a mean.
constexpr int kSumShift = 3;  // The sum of eight rows of differences fits 16 bits after this shift.
constexpr float kSumScale = 1 << (kMeanBits - kSumShift);
constexpr float kFirstNoise = 4;  // Assumed noise of the first frame, in 1/255.
/// Learning rate: per frame, the noise grows by at most 5 % or shrinks by at most 15 %.
constexpr float kLearning = 0.2F;
constexpr float kMostNoise = 8;      // Maximum noise, in 1/255.
constexpr float kTolerance = 0.25F;  // Mean differences below this are no change, in 1/255.
/// Ratio of the standard deviation of normally distributed noise to its mean magnitude.
constexpr float kDeviation = 1.25F;

std::int16_t to_mean(std::uint8_t sample) {
  return static_cast<std::int16_t>(sample << kMeanBits);
}

/// Returns the noise of the difference between a frame and a mean of `frames` earlier frames. The
/// unit is the noise of a single frame.
float widening(int frames) {
  return std::sqrt(1 + 1 / static_cast<float>(frames));
}

}  // namespace

bool ColorFilter::fits(const Picture& picture) const {
  return planes_[0].width == picture.width() && planes_[0].height == picture.height();
}

void ColorFilter::begin(const Picture& picture) {
  columns_ = (picture.width() + kBlock - 1) / kBlock;
  rows_ = (picture.height() + kBlock - 1) / kBlock;
  for (int p = 0; p < kPlanes; ++p) {
    Plane& plane = planes_[static_cast<std::size_t>(p)];
    plane.width = picture.plane_width(p);
    plane.height = picture.plane_height(p);
    plane.block = p == 0 ? kBlock : kBlock / 2;
    plane.mean.resize(picture.plane8(p).size());
    const auto padded = static_cast<std::size_t>(columns_ * plane.block);
    for (auto* row : {&plane.difference, &plane.magnitude, &plane.weight, &plane.jump})
      row->assign(padded, 0);
  }
  blocks_.resize(static_cast<std::size_t>(columns_ * rows_));
  for (Noise& noise : noise_) noise.magnitude.fill(kFirstNoise);
  keep(picture);
}

void ColorFilter::keep(const Picture& picture) {
  for (int p = 0; p < kPlanes; ++p) {
    const auto samples = picture.plane8(p);
    std::transform(samples.begin(), samples.end(), planes_[static_cast<std::size_t>(p)].mean.begin(),
                   to_mean);
  }
  std::fill(blocks_.begin(), blocks_.end(), Block{});
}

void ColorFilter::sum_rows(const Picture& picture, int p, int row) {
  Plane& plane = planes_[static_cast<std::size_t>(p)];
  const auto width = static_cast<std::size_t>(plane.width);
  std::fill(plane.difference.begin(), plane.difference.end(), std::int16_t{0});
  std::fill(plane.magnitude.begin(), plane.magnitude.end(), std::int16_t{0});
  for (int y = row * plane.block; y < std::min((row + 1) * plane.block, plane.height); ++y) {
    const std::size_t at = static_cast<std::size_t>(y) * width;
    const std::uint8_t* __restrict const now = picture.plane8(p).data() + at;
    const std::int16_t* __restrict const mean = plane.mean.data() + at;
    std::int16_t* __restrict const difference = plane.difference.data();
    std::int16_t* __restrict const magnitude = plane.magnitude.data();
    for (std::size_t x = 0; x < width; ++x) {
      const auto change = static_cast<std::int16_t>(to_mean(now[x]) - mean[x]);
      const auto size = static_cast<std::int16_t>(change < 0 ? -change : change);
      difference[x] = static_cast<std::int16_t>(difference[x] + (change >> kSumShift));
      magnitude[x] = static_cast<std::int16_t>(magnitude[x] + (size >> kSumShift));
    }
  }
}

ColorFilter::Difference ColorFilter::difference(const Plane& plane, int column, int row) const {
  int sum = 0, magnitude = 0;
  for (std::size_t x = static_cast<std::size_t>(column * plane.block),
                   end = x + static_cast<std::size_t>(plane.block);
       x < end; ++x) {
    sum += plane.difference[x];
    magnitude += plane.magnitude[x];
  }
  const int samples = std::min(plane.block, plane.width - column * plane.block) *
                      std::min(plane.block, plane.height - row * plane.block);
  const float scale = 1 / (kSumScale * static_cast<float>(samples));
  return {static_cast<float>(std::abs(sum)) * scale, static_cast<float>(magnitude) * scale};
}

int ColorFilter::brightness_at(int column, int row) const {
  const Plane& luma = planes_[0];
  const int x = std::min(column * kBlock + kBlock / 2, luma.width - 1);
  const int y = std::min(row * kBlock + kBlock / 2, luma.height - 1);
  return (luma.mean[static_cast<std::size_t>(y * luma.width + x)] >> kMeanBits) * kBrightnesses / 256;
}

const ColorFilter::Noise& ColorFilter::noise_at(int column, int row) const {
  return noise_[static_cast<std::size_t>(brightness_at(column, row))];
}

void ColorFilter::judge(int column, int row) {
  Block& block = block_at(column, row);
  const Noise& noise = noise_at(column, row);
  const float wider = widening(block.frames) / widening(kFrames);
  bool changes_slowly = false;
  block.magnitude = 0;
  for (std::size_t p = 0; p < kPlanes; ++p) {
    const Plane& plane = planes_[p];
    const Difference now = difference(plane, column, row);
    block.is_above_noise[p] = now.magnitude > noise.magnitude[p] * wider;
    const float expected = noise.magnitude[p] * wider;
    // A block has few samples of chroma. Their mean magnitude varies twice as much as that of luma.
    const float ratio = now.magnitude / (expected + kTolerance);
    block.magnitude = std::max(block.magnitude, p == 0 ? ratio : 1 + (ratio - 1) / 2);
    const float deviation = kDeviation * expected / static_cast<float>(plane.block);
    changes_slowly = changes_slowly || now.mean > kSlowChange * deviation + kTolerance;
  }
  block.moves = block.magnitude > kMotion;
  if (changes_slowly) block.frames = 1;
}

// Moves the noise towards the lower quartile of the blocks. The upper blocks may contain motion.
void ColorFilter::learn_noise() {
  constexpr float kQuartile = 0.75F;  // Share of blocks above the lower quartile.
  std::array<std::array<int, kPlanes>, kBrightnesses> above{};
  std::array<int, kBrightnesses> blocks{};
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const auto brightness = static_cast<std::size_t>(brightness_at(column, row));
      ++blocks[brightness];
      for (std::size_t p = 0; p < kPlanes; ++p)
        above[brightness][p] += block_at(column, row).is_above_noise[p];
    }
  }
  for (std::size_t brightness = 0; brightness < kBrightnesses; ++brightness) {
    if (blocks[brightness] == 0) continue;
    for (std::size_t p = 0; p < kPlanes; ++p) {
      const float share = static_cast<float>(above[brightness][p]) / static_cast<float>(blocks[brightness]);
      float& magnitude = noise_[brightness].magnitude[p];
      magnitude = std::clamp(magnitude * (1 + kLearning * (share - kQuartile)), kLeastNoise, kMostNoise);
    }
  }
}

// Restarts the means of moving blocks, and of changing blocks beside them.
void ColorFilter::end_changes() {
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      Block& block = block_at(column, row);
      if (block.magnitude <= kMotionBeside) continue;
      bool is_beside_motion = false;
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x)
          is_beside_motion = is_beside_motion || block_at(x, y).moves;
      }
      if (is_beside_motion) block.frames = 0;
    }
  }
}

// Returns true if most of the picture moves.
bool ColorFilter::find_motion(const Picture& picture) {
  int moving = 0;
  for (int row = 0; row < rows_; ++row) {
    for (int p = 0; p < kPlanes; ++p) sum_rows(picture, p, row);
    for (int column = 0; column < columns_; ++column) {
      judge(column, row);
      moving += block_at(column, row).moves;
    }
  }
  return static_cast<float>(moving) > kMostlyChanged * static_cast<float>(blocks_.size());
}

// Copies the results of a row of blocks to all their columns. Loops can then run over whole rows.
void ColorFilter::spread(int row) {
  constexpr float kLargest = 32767;
  for (int column = 0; column < columns_; ++column) {
    Block& block = block_at(column, row);
    const Noise& noise = noise_at(column, row);
    const float weight = 1 / static_cast<float>(block.frames + 1);
    for (std::size_t p = 0; p < kPlanes; ++p) {
      Plane& plane = planes_[p];
      const float jump = (kSampleJump * noise.magnitude[p] + 1) * (1 << kMeanBits);
      const int at = column * plane.block;
      std::fill_n(plane.weight.begin() + at, plane.block,
                  static_cast<std::int16_t>(std::min(weight * 65536, kLargest)));
      std::fill_n(plane.jump.begin() + at, plane.block,
                  block.frames == 0 ? std::int16_t{-1} : static_cast<std::int16_t>(std::min(jump, kLargest)));
    }
    block.frames = std::min(block.frames + 1, kFrames - 1);
  }
}

void ColorFilter::mix_rows(Picture& picture, int p, int row) {
  Plane& plane = planes_[static_cast<std::size_t>(p)];
  const auto width = static_cast<std::size_t>(plane.width);
  for (int y = row * plane.block; y < std::min((row + 1) * plane.block, plane.height); ++y) {
    const std::size_t at = static_cast<std::size_t>(y) * width;
    std::uint8_t* __restrict const shown = picture.plane8(p).data() + at;
    std::int16_t* __restrict const mean = plane.mean.data() + at;
    const std::int16_t* __restrict const weight = plane.weight.data();
    const std::int16_t* __restrict const jump = plane.jump.data();
    for (std::size_t x = 0; x < width; ++x) {
      const std::int16_t now = to_mean(shown[x]);
      const auto change = static_cast<std::int16_t>(now - mean[x]);
      const auto size = static_cast<std::int16_t>(change < 0 ? -change : change);
      const auto mixed = static_cast<std::int16_t>(mean[x] + ((change * weight[x]) >> 16));
      mean[x] = size > jump[x] ? now : mixed;
      shown[x] = static_cast<std::uint8_t>((mean[x] + (1 << (kMeanBits - 1))) >> kMeanBits);
    }
  }
}

void ColorFilter::apply(Picture& picture, bool camera_moves) {
  assert(picture.format() == PixelFormat::kYuv420);
  if (!fits(picture)) return begin(picture);
  if (camera_moves) return keep(picture);
  const bool mostly_changed = find_motion(picture);
  learn_noise();
  if (mostly_changed) return keep(picture);
  end_changes();
  for (int row = 0; row < rows_; ++row) {
    spread(row);
    for (int p = 0; p < kPlanes; ++p) mix_rows(picture, p, row);
  }
}

}  // namespace copresence::temporal_filter
