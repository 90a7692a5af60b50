#pragma once

// Frames of a clock that everybody on a machine reads: frame n is taken n / 30 s after the epoch of the system clock,
// so every simulated camera sees one instant, and cameras of several machines do as far as their clocks agree.
//
// Thread: a value.

#include <algorithm>
#include <cstdint>

namespace copresence::drivers {

class FrameClock {
 public:
  static constexpr std::int64_t kPerSecond = 30;

  static constexpr std::int64_t instant_us(std::int64_t frame) {
    return (frame * 1'000'000 + kPerSecond / 2) / kPerSecond;
  }

  /// The next frame to take when the clock says `now_us`, microseconds since its epoch: the first one after it, and
  /// later than every one before, unless the clock was set back by more than a second. Frames whose time has passed
  /// are left out.
  std::int64_t next(std::int64_t now_us) {
    std::int64_t frame = now_us * kPerSecond / 1'000'000 + 1;
    if (taken_ > 0 && frame <= last_ && last_ - frame < kPerSecond) frame = last_ + 1;
    index_ += taken_ > 0 && frame > last_ ? frame - last_ : 1;
    last_ = frame;
    ++taken_;
    return frame;
  }

  /// Counts frames from 1, those left out too: a gap is a loss.
  std::int64_t index() const { return index_; }

 private:
  std::int64_t taken_ = 0, last_ = 0, index_ = 0;
};

}  // namespace copresence::drivers
