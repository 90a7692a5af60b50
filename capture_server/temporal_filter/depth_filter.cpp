#include "capture_server/temporal_filter/depth_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace copresence::temporal_filter {
namespace {

constexpr int kFlickerShift = 4;      // The weight of a new frame in flicker_ is 1 / 2^4.
constexpr float kFlickerScale = 255;  // Value of flicker_ for a pixel that differs in every frame.
constexpr float kSmallestStep = 1e-3F;

}  // namespace

DepthFilter::DepthFilter(int width, int height, DepthUnit unit, const DepthNoise& noise)
    : width_(width),
      height_(height),
      columns_((width + kBlock - 1) / kBlock),
      rows_((height + kBlock - 1) / kBlock),
      step_per_square_(static_cast<float>(noise.step_m(1.0) * metres_per_unit(unit))),
      camera_(columns_, rows_) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  held_.resize(pixels);
  held_state_.resize(pixels);
  same_surface_.resize(pixels);
  steps_per_unit_.resize(pixels);
  mean_.resize(pixels);
  differs_.resize(pixels);
  flicker_.resize(pixels);
  doubts_.resize(pixels);
  blocks_.resize(static_cast<std::size_t>(columns_ * rows_));
  const auto padded = static_cast<std::size_t>(columns_ * kBlock);
  sums_.drift.resize(padded);
  for (auto* sums : {&sums_.differing, &sums_.jumping, &sums_.flicker, &sums_.with_depth})
    sums->resize(padded);
  other_surface_.resize(padded);
  weight_.resize(padded);
  attention_.resize(padded);
  stand_ins_.reserve(padded);
}

void DepthFilter::hold(std::size_t at, std::uint16_t depth, DepthState state) {
  const float z = depth, step = step_per_square_ * z * z;
  held_[at] = depth;
  held_state_[at] = state;
  same_surface_[at] = static_cast<std::uint16_t>(static_cast<int>(kOtherSurfaceSteps * step + 0.5F));
  steps_per_unit_[at] = depth ? 1 / std::max(step, kSmallestStep) : 0.0F;
  mean_[at] = 0;
  doubts_[at] = 0;
}

void DepthFilter::hold_all(const DepthImage& depth, const StateImage& state) {
  std::copy(depth.pixels().begin(), depth.pixels().end(), held_.begin());
  std::copy(state.pixels().begin(), state.pixels().end(), held_state_.begin());
  std::fill(mean_.begin(), mean_.end(), 0.0F);
  std::fill(doubts_.begin(), doubts_.end(), std::uint8_t{0});
  std::fill(flicker_.begin(), flicker_.end(), std::uint8_t{0});
  const std::uint16_t* __restrict const held = held_.data();
  std::uint16_t* __restrict const same_surface = same_surface_.data();
  float* __restrict const steps_per_unit = steps_per_unit_.data();
  const std::size_t pixels = held_.size();
  const float step_per_square = step_per_square_;
  for (std::size_t at = 0; at < pixels; ++at) {
    const float z = held[at], step = step_per_square * z * z;
    steps_per_unit[at] = z > 0 ? 1 / std::max(step, kSmallestStep) : 0.0F;
  }
  for (std::size_t at = 0; at < pixels; ++at) {
    const float z = held[at], step = step_per_square * z * z;
    same_surface[at] = static_cast<std::uint16_t>(static_cast<int>(kOtherSurfaceSteps * step + 0.5F));
  }
}

// Each loop uses as few number types as possible, so that the compiler can vectorise it.
void DepthFilter::compare_row(const DepthImage& depth, const StateImage& state, int y) {
  const auto width = static_cast<std::size_t>(width_);
  const std::size_t at = static_cast<std::size_t>(y) * width;
  const std::uint16_t* __restrict const now = depth.data() + at;
  const std::uint16_t* __restrict const held = held_.data() + at;
  const std::uint16_t* __restrict const same_surface = same_surface_.data() + at;
  const DepthState* __restrict const now_state = state.data() + at;
  const DepthState* __restrict const held_state = held_state_.data() + at;
  const std::uint8_t* __restrict const flicker = flicker_.data() + at;
  const float* __restrict const steps_per_unit = steps_per_unit_.data() + at;
  const float* __restrict const mean = mean_.data() + at;
  std::uint8_t* __restrict const differs = differs_.data() + at;
  std::uint16_t* __restrict const differing = sums_.differing.data();
  std::uint16_t* __restrict const other_surface = other_surface_.data();
  std::uint16_t* __restrict const jumping = sums_.jumping.data();
  std::uint16_t* __restrict const usual = sums_.flicker.data();
  std::uint16_t* __restrict const with_depth = sums_.with_depth.data();
  float* __restrict const drift = sums_.drift.data();
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint16_t near = std::min(now[x], held[x]), off = std::max(now[x], held[x]) - near;
    const std::uint16_t is_other = off > same_surface[x] ? 1 : 0;
    other_surface[x] = is_other;
    jumping[x] = static_cast<std::uint16_t>(jumping[x] + (near > 0 ? is_other : 0));
  }
  for (std::size_t x = 0; x < width; ++x)
    with_depth[x] = static_cast<std::uint16_t>(with_depth[x] + ((now[x] | held[x]) > 0 ? 1 : 0));
  for (std::size_t x = 0; x < width; ++x) differs[x] = static_cast<std::uint8_t>(other_surface[x]);
  for (std::size_t x = 0; x < width; ++x) differs[x] |= now_state[x] != held_state[x];
  for (std::size_t x = 0; x < width; ++x) {
    differing[x] = static_cast<std::uint16_t>(differing[x] + differs[x]);
    usual[x] = static_cast<std::uint16_t>(usual[x] + flicker[x]);
  }
  for (std::size_t x = 0; x < width; ++x) {
    const float off = static_cast<float>(now[x] - held[x]) * steps_per_unit[x] - mean[x];
    drift[x] += off * static_cast<float>(1 - differs[x]);
  }
}

void DepthFilter::sum_blocks(int row) {
  for (int column = 0; column < columns_; ++column) {
    Block& block = block_at(column, row);
    int flicker = 0;
    block = {};
    for (std::size_t x = static_cast<std::size_t>(column * kBlock), end = x + kBlock; x < end; ++x) {
      block.differing += sums_.differing[x];
      block.jumping += sums_.jumping[x];
      block.with_depth += sums_.with_depth[x];
      block.drift += sums_.drift[x];
      flicker += sums_.flicker[x];
    }
    block.usual = static_cast<float>(flicker) / kFlickerScale;
  }
}

void DepthFilter::compare(const DepthImage& depth, const StateImage& state) {
  for (int row = 0; row < rows_; ++row) {
    std::fill(sums_.drift.begin(), sums_.drift.end(), 0.0F);
    for (auto* sums : {&sums_.differing, &sums_.jumping, &sums_.flicker, &sums_.with_depth})
      std::fill(sums->begin(), sums->end(), std::uint16_t{0});
    for (int y = row * kBlock; y < std::min((row + 1) * kBlock, height_); ++y) compare_row(depth, state, y);
    sum_blocks(row);
  }
}

// Returns true if the camera moves.
bool DepthFilter::find_motion() {
  for (int row = 0; row < rows_; ++row) {
    const int height = std::min(kBlock, height_ - row * kBlock);
    for (int column = 0; column < columns_; ++column) {
      Block& block = block_at(column, row);
      const auto pixels = static_cast<float>(height * std::min(kBlock, width_ - column * kBlock));
      const auto differing = static_cast<float>(block.differing);
      const auto agreeing = static_cast<float>(block.with_depth - block.differing);
      // The mean of fewer pixels is noisier, so its drift counts less.
      const float drift = std::abs(block.drift) / std::sqrt(std::max(agreeing, 1.0F)) / kBlock;
      const float motion =
          agreeing < kFewestPixels ? 0 : (drift - kNoiseSteps) / (kMotionSteps - kNoiseSteps);
      block.weight = std::clamp(motion, kMeanWeight, 1.0F);
      block.excess = differing - block.usual - kDeviations * std::sqrt(block.usual);
      block.moves = block.excess > kMotionPixels || block.weight > 0.5F;
      block.is_replaced = differing > kReplaced * pixels;
      // Flickering holes are no sign of a moving camera.
      const bool surface_moves = static_cast<float>(block.jumping) > kMotionPixels || block.weight > 0.5F;
      if (block.with_depth >= kFewestPixels) camera_.add(column, row, surface_moves);
    }
  }
  return camera_.end_frame();
}

void DepthFilter::spread_motion() {
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      if (block_at(column, row).excess <= kStrongMotionPixels) continue;
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x)
          block_at(x, y).is_near_motion = true;
      }
    }
  }
}

bool DepthFilter::differs_in_depth(std::uint16_t depth, std::size_t at) const {
  return std::abs(depth - held_[at]) > same_surface_[at];
}

// Returns true if a pixel that differs from its held value takes the new value in this frame.
bool DepthFilter::accepts(const Block& block, std::uint16_t depth, std::size_t at) const {
  if (block.is_replaced) return true;
  const bool is_in_motion = block.moves || block.is_near_motion;
  const bool gains_depth = held_[at] == 0, loses_depth = depth == 0;
  if (!gains_depth && !loses_depth && differs_in_depth(depth, at)) {
    if (is_in_motion) return true;
    return doubts_[at] + 1 >= (flicker_[at] >= kFlickering ? kFlickeringDepthFrames : kConfirmingFrames);
  }
  // A hole begins or ends, or a pixel changes between measured and filled. Only new depth within
  // motion is urgent.
  if (gains_depth && is_in_motion && flicker_[at] < kSteady) return true;
  return doubts_[at] + 1 >= kStateFrames;
}

// Searches up, down, left and right for the nearest pixel with depth within kReach. Returns the
// farthest of these depths, or 0 if there is none.
std::uint16_t DepthFilter::surface_behind(const DepthImage& depth, int x, int y) const {
  std::uint16_t farthest = 0;
  for (const auto& [right, down] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
    for (int distance = 1; distance <= kReach; ++distance) {
      const int column = x + right * distance, row = y + down * distance;
      if (column < 0 || column >= width_ || row < 0 || row >= height_) break;
      if (depth(column, row) == 0) continue;
      farthest = std::max(farthest, depth(column, row));
      break;
    }
  }
  return farthest;
}

void DepthFilter::update_means(const std::uint16_t* depth, std::size_t at) {
  const auto width = static_cast<std::size_t>(width_);
  const std::uint16_t* __restrict const now = depth;
  const std::uint16_t* __restrict const held = held_.data() + at;
  const float* __restrict const steps_per_unit = steps_per_unit_.data() + at;
  const float* __restrict const weight = weight_.data();
  const std::uint8_t* __restrict const differs = differs_.data() + at;
  const std::uint8_t* __restrict const doubts = doubts_.data() + at;
  float* __restrict const mean = mean_.data() + at;
  std::uint8_t* __restrict const flicker = flicker_.data() + at;
  std::uint8_t* __restrict const attention = attention_.data();
  for (std::size_t x = 0; x < width; ++x) {
    const float off = static_cast<float>(now[x] - held[x]) * steps_per_unit[x];
    mean[x] += (off - mean[x]) * weight[x] * static_cast<float>(1 - differs[x]);
    attention[x] = (std::abs(mean[x]) > kHeldSteps) & (std::abs(off - mean[x]) <= kNearMeanSteps);
  }
  for (std::size_t x = 0; x < width; ++x) attention[x] |= differs[x] | doubts[x];
  for (std::size_t x = 0; x < width; ++x)
    flicker[x] = static_cast<std::uint8_t>(flicker[x] + ((255 * differs[x] - flicker[x]) >> kFlickerShift));
}

void DepthFilter::filter_row(DepthImage& depth, StateImage& state, int y) {
  const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  std::uint16_t* const now = depth.data() + at;
  DepthState* const now_state = state.data() + at;
  update_means(now, at);
  stand_ins_.clear();
  for (int x = 0; x < width_; ++x) {
    if (!attention_[static_cast<std::size_t>(x)]) continue;
    const std::size_t pixel = at + static_cast<std::size_t>(x);
    const Block& block = block_at(x / kBlock, y / kBlock);
    if (!differs_[pixel]) {
      if (doubts_[pixel] > 0) --doubts_[pixel];
      const float mean = mean_[pixel],
                  off = static_cast<float>(now[x] - held_[pixel]) * steps_per_unit_[pixel];
      if (std::abs(mean) <= kHeldSteps || std::abs(off - mean) > kNearMeanSteps) continue;
      hold(pixel, now[x], now_state[x]);
      mean_[pixel] = mean - off;
      continue;
    }
    // A surface that has left this pixel must not stay there as a ghost.
    const bool has_left = now[x] == 0 && (block.moves || block.is_near_motion);
    const std::uint16_t behind = has_left ? surface_behind(depth, x, y) : std::uint16_t{0};
    if (accepts(block, now[x], pixel) || (has_left && behind == 0)) {
      hold(pixel, now[x], now_state[x]);
    } else {
      ++doubts_[pixel];
      if (behind > held_[pixel] + same_surface_[pixel]) stand_ins_.emplace_back(x, behind);
    }
  }
  std::copy_n(held_.data() + at, width_, now);
  std::copy_n(held_state_.data() + at, width_, now_state);
  for (const auto& [x, behind] : stand_ins_) now[x] = behind;
}

void DepthFilter::apply(DepthImage& depth, StateImage& state) {
  assert(depth.width() == width_ && depth.height() == height_ && same_shape(depth, state));
  if (!has_begun_) {
    has_begun_ = true;
    return hold_all(depth, state);
  }
  compare(depth, state);
  const bool was_moving = camera_.is_moving();
  if (find_motion()) return hold_all(depth, state);
  // Until the camera counts as still, each frame is compared with the last frame in motion.
  if (camera_.is_moving()) return;
  if (was_moving) return hold_all(depth, state);
  spread_motion();
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column)
      std::fill_n(weight_.begin() + column * kBlock, kBlock, block_at(column, row).weight);
    for (int y = row * kBlock; y < std::min((row + 1) * kBlock, height_); ++y) filter_row(depth, state, y);
  }
}

}  // namespace copresence::temporal_filter
