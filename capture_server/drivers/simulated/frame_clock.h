#pragma once

// The frame clock of all simulated cameras of a machine. Frame n is captured n / 30 s after the
// epoch of the system clock, so all cameras capture at the same instants. Cameras on several
// machines capture at the same instants as far as the machines' clocks agree.
// Thread: one thread at a time per object.

#include <algorithm>
#include <cstdint>

namespace copresence::drivers {

class FrameClock {
 public:
  static constexpr std::int64_t kPerSecond = 30;

  static constexpr std::int64_t instant_us(std::int64_t frame) {
    return (frame * 1'000'000 + kPerSecond / 2) / kPerSecond;
  }

  /// Returns the first frame after the time `now_us` and after the previous frame. `now_us` is in
  /// microseconds since the epoch. Frames whose time has passed are skipped. If the clock was set
  /// back by more than a second, frame numbers decrease.
  std::int64_t next(std::int64_t now_us) {
    std::int64_t frame = now_us * kPerSecond / 1'000'000 + 1;
    if (taken_ > 0 && frame <= last_ && last_ - frame < kPerSecond) frame = last_ + 1;
    index_ += taken_ > 0 && frame > last_ ? frame - last_ : 1;
    last_ = frame;
    ++taken_;
    return frame;
  }

  /// The number of the frame, counted from 1. Skipped frames count, so a gap means lost frames.
  std::int64_t index() const { return index_; }

 private:
  std::int64_t taken_ = 0, last_ = 0, index_ = 0;
};

}  // namespace copresence::drivers
