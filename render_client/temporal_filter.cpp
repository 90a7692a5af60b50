#include "render_client/temporal_filter.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace copresence::client {
namespace {

constexpr int kMeanShift = 3;
static_assert(1 << kMeanShift == TemporalFilter::kFrames);
constexpr int kFewestPixels = 16;  // of a block, whose mean difference says something

const std::uint8_t* bytes(const ColorImage& color) {
  static_assert(sizeof(Rgb8) == 3);
  return reinterpret_cast<const std::uint8_t*>(color.data());
}

}  // namespace

bool TemporalFilter::fits(const RgbdFrame& frame) const {
  return width_ == frame.depth.width() && height_ == frame.depth.height() &&
         kept_.color.size() == (frame.color ? 3 * kept_.depth.size() : 0);
}

void TemporalFilter::begin(const RgbdFrame& frame) {
  width_ = frame.depth.width();
  height_ = frame.depth.height();
  columns_ = (width_ + kBlock - 1) / kBlock;
  const std::size_t pixels = frame.depth.pixels().size();
  kept_.depth.assign(frame.depth.pixels().begin(), frame.depth.pixels().end());
  kept_.state.assign(frame.state.pixels().begin(), frame.state.pixels().end());
  kept_.frames.assign(pixels, 1);
  kept_.missed.assign(pixels, 0);
  kept_.color.resize(frame.color ? 3 * pixels : 0);
  for (std::size_t i = 0; i < kept_.color.size(); ++i)
    kept_.color[i] = static_cast<std::uint16_t>(bytes(*frame.color)[i] << 8);
}

TemporalFilter::Block TemporalFilter::judge_block(const RgbdFrame& frame, int left, int top) const {
  const int columns = std::min(kBlock, width_ - left), rows = std::min(kBlock, height_ - top);
  float difference = 0, agreeing = 0, jumping = 0;
  int recolored = 0;
  const auto sum = [&](std::size_t at, int count) {
    const std::uint16_t* const measured = frame.depth.data() + at;
    const float* const kept = kept_.depth.data() + at;
    for (int x = 0; x < count; ++x) {
      const float z = measured[x], before = kept[x], step = step_per_square_ * before * before;
      const float there = z > 0 && before > 0 ? 1.0F : 0.0F;
      const float agrees = std::abs(z - before) <= kJump * step ? there : 0.0F;
      difference += agrees * (z - before) / std::max(step, 1e-3F);
      agreeing += agrees;
      jumping += there - agrees;
    }
    if (!frame.color) return;
    const std::uint8_t* const color = bytes(*frame.color) + 3 * at;
    const std::uint16_t* const kept_color = kept_.color.data() + 3 * at;
    for (int i = 0; i < 3 * count; ++i) recolored += std::abs((color[i] << 8) - kept_color[i]);
  };
  for (int y = top; y < top + rows; ++y) {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(left);
    if (columns == kBlock) {
      sum(at, kBlock);  // a number that the compiler knows
    } else {
      sum(at, columns);
    }
  }
  Block block;
  if (agreeing >= kFewestPixels)
    block.gain = std::clamp((std::abs(difference) / agreeing - kNoise) / (kMotion - kNoise), 0.0F, 1.0F);
  if (2 * jumping > static_cast<float>(columns * rows)) block.gain = 1;
  block.is_recolored = recolored > (kColorMotion << 8) * 3 * columns * rows;
  return block;
}

bool TemporalFilter::judge(const RgbdFrame& frame) {
  blocks_.clear();
  int moving = 0;
  for (int top = 0; top < height_; top += kBlock) {
    for (int left = 0; left < width_; left += kBlock) {
      blocks_.push_back(judge_block(frame, left, top));
      moving += blocks_.back().gain > 0.5F || blocks_.back().is_recolored;
    }
  }
  return static_cast<float>(moving) > kMovingShare * static_cast<float>(blocks_.size());
}

bool TemporalFilter::is_recolored(const RgbdFrame& frame, std::size_t at) const {
  if (!frame.color) return false;
  for (std::size_t i = 3 * at; i < 3 * at + 3; ++i) {
    if (std::abs((bytes(*frame.color)[i] << 8) - kept_.color[i]) > kColorJump << 8) return true;
  }
  return false;
}

// A pixel that does not simply go on: it gained, lost or changed its state, or jumped.
void TemporalFilter::decide(RgbdFrame& frame, const Block& block, std::size_t at) {
  const DepthState before = kept_.state[at], now = frame.state.data()[at];
  const bool has_more =
      before == DepthState::kHole || (before == DepthState::kFilled && now == DepthState::kMeasured);
  const bool has_less =
      now == DepthState::kHole || (now == DepthState::kFilled && before == DepthState::kMeasured);
  const int patience = has_less ? kKeptFrames : 1;
  const bool waits = !has_more && kept_.missed[at] < patience && block.gain <= 0.5F && !block.is_recolored &&
                     !is_recolored(frame, at);
  if (waits) {
    ++kept_.missed[at];
    return;
  }
  kept_.depth[at] = frame.depth.data()[at];
  kept_.state[at] = now;
  kept_.frames[at] = 1;
  kept_.missed[at] = 0;
}

void TemporalFilter::mix_depth(RgbdFrame& frame) {
  const float jump_per_square = kJump * step_per_square_;
  for (int y = 0; y < height_; ++y) {
    for (int left = 0; left < width_; left += kBlock) {
      const Block& block = block_of(left, y);
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(left);
      std::uint16_t* const depth = frame.depth.data() + at;
      DepthState* const state = frame.state.data() + at;
      float* const kept = kept_.depth.data() + at;
      std::uint8_t* const frames = kept_.frames.data() + at;
      std::uint8_t* const missed = kept_.missed.data() + at;
      const DepthState* const kept_state = kept_.state.data() + at;
      const float least_gain = block.is_recolored ? 1.0F : block.gain;
      unsigned others = 0;  // one bit per pixel
      const auto mix = [&](int count) {
        for (int x = 0; x < count; ++x) {
          const float z = depth[x], before = kept[x];
          const bool goes_on =
              state[x] == kept_state[x] && std::abs(z - before) <= jump_per_square * before * before;
          const int mean_of = std::min(frames[x] + 1, kFrames);
          const float gain = std::max(1.0F / static_cast<float>(mean_of), least_gain);
          kept[x] = goes_on ? before + gain * (z - before) : before;
          frames[x] = static_cast<std::uint8_t>(goes_on ? mean_of : frames[x]);
          missed[x] = goes_on ? std::uint8_t{0} : missed[x];
          others |= goes_on ? 0U : 1U << x;
        }
      };
      const int columns = std::min(kBlock, width_ - left);
      if (columns == kBlock) {
        mix(kBlock);  // a number that the compiler knows
      } else {
        mix(columns);
      }
      for (int x = 0; others; ++x, others >>= 1) {
        if (others & 1U) decide(frame, block, at + static_cast<std::size_t>(x));
      }
      for (int x = 0; x < columns; ++x) depth[x] = static_cast<std::uint16_t>(kept[x] + 0.5F);
      std::copy_n(kept_state, columns, state);
    }
  }
}

void TemporalFilter::mix_color(ColorImage& color) {
  auto* const colors = reinterpret_cast<std::uint8_t*>(color.data());
  for (int y = 0; y < height_; ++y) {
    for (int left = 0; left < width_; left += kBlock) {
      const int jump = block_of(left, y).is_recolored ? -1 : kColorJump << 8;
      const std::size_t at = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                  static_cast<std::size_t>(left));
      std::uint8_t* const shown = colors + at;
      std::uint16_t* const kept = kept_.color.data() + at;
      const auto mix = [&](int count) {
        for (int i = 0; i < count; ++i) {
          const int now = shown[i] << 8, change = now - kept[i];
          const int mixed = kept[i] + (change >> kMeanShift);
          kept[i] = static_cast<std::uint16_t>(std::abs(change) > jump ? now : mixed);
          shown[i] = static_cast<std::uint8_t>((kept[i] + 128) >> 8);
        }
      };
      const int columns = std::min(kBlock, width_ - left);
      if (columns == kBlock) {
        mix(3 * kBlock);
      } else {
        mix(3 * columns);
      }
    }
  }
}

void TemporalFilter::apply(RgbdFrame& frame, DepthUnit unit) {
  step_per_square_ = static_cast<float>(sensor_step_m(1.0) * metres_per_unit(unit));
  if (!fits(frame) || judge(frame)) return begin(frame);
  mix_depth(frame);
  if (frame.color) mix_color(*frame.color);
}

}  // namespace copresence::client
