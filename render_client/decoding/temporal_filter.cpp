#include "render_client/decoding/temporal_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <utility>

namespace copresence::decoding {
namespace {

constexpr int kMeanShift = 3;
static_assert(1 << kMeanShift == TemporalFilter::kFrames);
constexpr int kColorBits = 7;  // Fractional bits of Kept::color.
// Colour differences are shifted right by this, so that the sum of eight rows fits into 16 bits.
constexpr int kSumShift = 3;
// The mean difference of fewer pixels than this is not meaningful.
constexpr int kFewestPixels = 16;

const std::uint8_t* bytes(const ColorImage& color) {
  static_assert(sizeof(Rgb8) == 3);
  return reinterpret_cast<const std::uint8_t*>(color.data());
}

std::int16_t kept_color(std::uint8_t value) {
  return static_cast<std::int16_t>(value << kColorBits);
}

}  // namespace

bool TemporalFilter::fits(const RgbdFrame& frame) const {
  return width_ == frame.depth.width() && height_ == frame.depth.height();
}

void TemporalFilter::begin(const RgbdFrame& frame) {
  width_ = frame.depth.width();
  height_ = frame.depth.height();
  columns_ = (width_ + kBlock - 1) / kBlock;
  const std::size_t pixels = frame.depth.pixels().size();
  kept_.depth.resize(pixels);
  kept_.color.resize(frame.color ? 3 * pixels : 0);
  has_color_ = frame.color.has_value();
  keep_pictures(frame, 1);
  kept_.state.assign(frame.state.pixels().begin(), frame.state.pixels().end());
  kept_.frames.assign(pixels, 1.0F);
  kept_.missed.assign(pixels, 0);
  camera_moves_ = false;
}

void TemporalFilter::begin_color(const ColorImage& color) {
  const std::size_t count = 3 * color.pixels().size();
  kept_.color.resize(count);
  std::transform(bytes(color), bytes(color) + count, kept_.color.data(), kept_color);
}

void TemporalFilter::keep_pictures(const RgbdFrame& frame, int every) {
  const auto width = static_cast<std::size_t>(width_);
  for (int top = 0; top < height_; top += every * kBlock) {
    const std::size_t at = static_cast<std::size_t>(top) * width;
    const std::size_t pixels = static_cast<std::size_t>(std::min(kBlock, height_ - top)) * width;
    std::copy_n(frame.depth.data() + at, pixels, kept_.depth.data() + at);
    if (!frame.color) continue;
    std::transform(bytes(*frame.color) + 3 * at, bytes(*frame.color) + 3 * (at + pixels),
                   kept_.color.data() + 3 * at, kept_color);
  }
}

void TemporalFilter::sum_row(const RgbdFrame& frame, int y) {
  const std::size_t width = static_cast<std::size_t>(width_), at = static_cast<std::size_t>(y) * width;
  const std::uint16_t* __restrict const measured = frame.depth.data() + at;
  const float* __restrict const kept = kept_.depth.data() + at;
  float* __restrict const difference = sums_.difference.data();
  float* __restrict const agreeing = sums_.agreeing.data();
  float* __restrict const jumping = sums_.jumping.data();
  for (std::size_t x = 0; x < width; ++x) {
    const float z = measured[x], before = kept[x], step = step_per_square_ * before * before;
    const float there = (z > 0 ? 1.0F : 0.0F) * (before > 0 ? 1.0F : 0.0F);
    const float agrees = std::abs(z - before) <= kJump * step ? there : 0.0F;
    difference[x] += agrees * (z - before) / std::max(step, 1e-3F);
    agreeing[x] += agrees;
    jumping[x] += there - agrees;
  }
  if (!frame.color) return;
  const std::uint8_t* __restrict const color = bytes(*frame.color) + 3 * at;
  const std::int16_t* __restrict const before = kept_.color.data() + 3 * at;
  std::int16_t* __restrict const recolored = sums_.recolored.data();
  for (std::size_t i = 0; i < 3 * width; ++i) {
    const auto change = static_cast<std::int16_t>(kept_color(color[i]) - before[i]);
    const auto size = static_cast<std::int16_t>(change < 0 ? -change : change);
    recolored[i] = static_cast<std::int16_t>(recolored[i] + (size >> kSumShift));
  }
}

TemporalFilter::Block TemporalFilter::judge_block(int left, int rows) const {
  static_assert(kBlock == 8);
  // The numbers are added in pairs: a chain of dependent additions would take most of the time.
  const auto sum = [left](const std::vector<float>& of) {
    const float* const v = of.data() + left;
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
  };
  const int pixels = std::min(kBlock, width_ - left) * rows;
  const float agreeing = sum(sums_.agreeing), jumping = sum(sums_.jumping);
  Block block;
  if (agreeing >= kFewestPixels) {
    const float mean = std::abs(sum(sums_.difference)) / agreeing;
    block.gain = std::clamp((mean - kNoise) / (kMotion - kNoise), 0.0F, 1.0F);
  }
  if (2 * jumping > static_cast<float>(pixels)) block.gain = 1;
  if (sums_.recolored.empty()) return block;
  const std::int16_t* const recolored = sums_.recolored.data() + 3 * left;
  block.is_recolored = std::accumulate(recolored, recolored + 3 * kBlock, 0) >
                       (kColorMotion << (kColorBits - kSumShift)) * 3 * pixels;
  return block;
}

bool TemporalFilter::judge(const RgbdFrame& frame, int every) {
  // Columns beyond the image stay 0.
  const auto width = static_cast<std::size_t>(columns_ * kBlock);
  blocks_.clear();
  int moving = 0;
  for (int top = 0; top < height_; top += every * kBlock) {
    for (auto* sums : {&sums_.difference, &sums_.agreeing, &sums_.jumping}) sums->assign(width, 0.0F);
    sums_.recolored.assign(frame.color ? 3 * width : 0, 0);
    const int rows = std::min(kBlock, height_ - top);
    for (int y = top; y < top + rows; ++y) sum_row(frame, y);
    for (int left = 0; left < width_; left += kBlock) {
      blocks_.push_back(judge_block(left, rows));
      moving += blocks_.back().moves();
    }
  }
  return static_cast<float>(moving) > kMovingShare * static_cast<float>(blocks_.size());
}

// A block counts as still only if its neighbours are. Beside moving blocks, coding noise would
// decide whether the block is still.
void TemporalFilter::find_still() {
  const int rows = static_cast<int>(blocks_.size()) / columns_;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns_; ++column) {
      Block& block = blocks_[static_cast<std::size_t>(row * columns_ + column)];
      block.is_still = true;
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x)
          block.is_still = block.is_still && !blocks_[static_cast<std::size_t>(y * columns_ + x)].moves();
      }
    }
  }
}

// Keeps or replaces the old depth of a pixel whose state changed or whose depth jumped.
void TemporalFilter::decide(const RgbdFrame& frame, const Block& block, std::size_t at) {
  const DepthState before = kept_.state[at], now = frame.state.data()[at];
  const bool has_more =
      before == DepthState::kHole || (before == DepthState::kFilled && now == DepthState::kMeasured);
  const bool has_less =
      now == DepthState::kHole || (now == DepthState::kFilled && before == DepthState::kMeasured);
  const int patience = has_less ? kKeptFrames : 1;
  const bool waits = !has_more && block.is_still && kept_.missed[at] < patience;
  if (waits) {
    kept_.missed[at] = static_cast<std::uint8_t>(std::min(kept_.missed[at] + frames_since_, 255));
    return;
  }
  kept_.depth[at] = frame.depth.data()[at];
  kept_.state[at] = now;
  kept_.frames[at] = 1;
  kept_.missed[at] = 0;
}

// Copies the results of each block to all its columns, so that later loops run over whole rows.
void TemporalFilter::spread(int block_row) {
  const auto width = static_cast<std::size_t>(width_);
  spread_.gain.resize(width);
  spread_.jump.resize(3 * width);
  for (int left = 0; left < width_; left += kBlock) {
    const Block& block = blocks_[static_cast<std::size_t>(block_row * columns_ + left / kBlock)];
    const int columns = std::min(kBlock, width_ - left);
    std::fill_n(spread_.gain.begin() + left, columns, block.is_recolored ? 1.0F : block.gain);
    std::fill_n(spread_.jump.begin() + 3 * left, 3 * columns,
                static_cast<std::int16_t>(block.is_recolored ? -1 : kColorJump << kColorBits));
  }
}

void TemporalFilter::mix_depth(RgbdFrame& frame, int y) {
  const float jump_per_square = kJump * step_per_square_;
  const std::size_t width = static_cast<std::size_t>(width_), at = static_cast<std::size_t>(y) * width;
  std::uint16_t* __restrict const depth = frame.depth.data() + at;
  const DepthState* __restrict const state = frame.state.data() + at;
  float* __restrict const kept = kept_.depth.data() + at;
  float* __restrict const frames = kept_.frames.data() + at;
  std::uint8_t* __restrict const missed = kept_.missed.data() + at;
  const DepthState* __restrict const kept_state = kept_.state.data() + at;
  const float* __restrict const least_gain = spread_.gain.data();
  changed_.resize(width);
  goes_on_.resize(width);
  std::uint8_t* __restrict const changed = changed_.data();
  float* __restrict const goes_on = goes_on_.data();
  // Each loop uses a single number type, so that the compiler can vectorise it.
  for (std::size_t x = 0; x < width; ++x) changed[x] = state[x] != kept_state[x];
  for (std::size_t x = 0; x < width; ++x) goes_on[x] = 1.0F - static_cast<float>(changed[x]);
  for (std::size_t x = 0; x < width; ++x) {
    const float z = depth[x], before = kept[x];
    const float agrees = std::abs(z - before) <= jump_per_square * before * before ? goes_on[x] : 0.0F;
    const float mean_of = std::min(frames[x] + 1, static_cast<float>(kFrames));
    const float gain = std::max(1 / mean_of, least_gain[x]);
    kept[x] = before + agrees * gain * (z - before);
    frames[x] += agrees * (mean_of - frames[x]);
    goes_on[x] = agrees;
  }
  for (std::size_t x = 0; x < width; ++x) changed[x] = goes_on[x] == 0.0F;
  for (std::size_t x = 0; x < width; ++x) missed[x] = static_cast<std::uint8_t>(changed[x] * missed[x]);
  for (std::size_t x = 0; x < width; ++x) {
    const void* const found = std::memchr(changed + x, 1, width - x);
    if (found == nullptr) break;
    x = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - changed);
    decide(frame, block_of(static_cast<int>(x), y), at + x);
  }
  for (std::size_t x = 0; x < width; ++x)
    depth[x] = static_cast<std::uint16_t>(static_cast<int>(kept[x] + 0.5F));
  std::copy_n(kept_state, width, frame.state.data() + at);
}

void TemporalFilter::mix_color(ColorImage& color, int y) {
  const std::size_t count = 3 * static_cast<std::size_t>(width_), at = static_cast<std::size_t>(y) * count;
  std::uint8_t* __restrict const shown = reinterpret_cast<std::uint8_t*>(color.data()) + at;
  std::int16_t* __restrict const kept = kept_.color.data() + at;
  const std::int16_t* __restrict const jump = spread_.jump.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int16_t now = kept_color(shown[i]);
    const auto change = static_cast<std::int16_t>(now - kept[i]);
    const auto size = static_cast<std::int16_t>(change < 0 ? -change : change);
    const auto mixed = static_cast<std::int16_t>(kept[i] + (change >> kMeanShift));
    kept[i] = size > jump[i] ? now : mixed;
    shown[i] = static_cast<std::uint8_t>((kept[i] + (1 << (kColorBits - 1))) >> kColorBits);
  }
}

void TemporalFilter::apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise) {
  step_per_square_ = static_cast<float>(noise.step_m(1.0) * metres_per_unit(unit));
  frames_since_ = static_cast<int>(std::clamp<std::uint64_t>(frame.metadata.sequence - sequence_, 1, 255));
  sequence_ = frame.metadata.sequence;
  if (!fits(frame)) return begin(frame);
  // If the last frame had no colour, the mean colours start anew. Missing colour does not affect
  // the depth filter.
  if (frame.color && !has_color_) begin_color(*frame.color);
  has_color_ = frame.color.has_value();
  // A few blocks are enough to detect that a moving camera still moves.
  const bool moved = std::exchange(camera_moves_, judge(frame, camera_moves_ ? kGlance : 1));
  if (camera_moves_) return keep_pictures(frame, kGlance);
  if (moved) return begin(frame);
  find_still();
  for (int y = 0; y < height_; ++y) {
    if (y % kBlock == 0) spread(y / kBlock);
    mix_depth(frame, y);
    if (frame.color) mix_color(*frame.color, y);
  }
}

}  // namespace copresence::decoding
