#pragma once

// Computes when each frame of a recording is due. It uses the timestamps and one starting instant,
// never the time at which the previous frame was shown, so it does not drift.
//
// Without a given instant, a replay begins at a whole fifth of a second of the machine's clock. So
// replays of the common frame rates are in phase, like cameras with a common trigger. Viewers then
// need not wait for the latest of them, and measurements are repeatable.
//
// Thread: a value.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

class PlaybackSchedule {
 public:
  static constexpr Duration kStep =
      std::chrono::milliseconds(200);  ///< whole periods at 5, 10, 15, 25, 30 and 60 Hz

  /// `period`: the usual time between frames, for recordings with unusable timestamps. `begin`:
  /// when the first frame is due. Without it, or if it has passed, the next whole step.
  explicit PlaybackSchedule(Duration period, std::optional<Instant> begin = std::nullopt)
      : period_(period), begin_(begin) {}

  /// The instant at which the frame with this timestamp is due; `now` is the present time. A pause
  /// of more than a second is shortened to one. If timestamps stand still or decrease, frames
  /// follow each other by the period. The time gained this way, up to a second, is taken from later
  /// steps, which stay at least one period long. If a call comes more than 0.2 s late (the process
  /// was suspended, say), the remaining schedule is shifted instead of producing a burst of frames.
  Instant due(std::int64_t timestamp_us, Instant now) {
    using std::chrono::microseconds;
    if (!begun_) {
      begun_ = true;
      due_ = begin_ && *begin_ > now ? *begin_ : in_sync(now);
    } else {
      const Duration step =
          microseconds(std::clamp<std::int64_t>(timestamp_us - last_us_, 0, kLongestPauseUs));
      Duration advance = step - ahead_;
      if (step == Duration::zero() || ahead_ > Duration::zero()) advance = std::max(advance, period_);
      ahead_ = std::clamp<Duration>(ahead_ + advance - step, Duration::zero(), microseconds(kLongestPauseUs));
      due_ += advance;
      if (now - due_ > kLate) due_ = now;
    }
    last_us_ = timestamp_us;
    return due_;
  }

  /// The next whole step of the clock.
  static Instant in_sync(Instant now) { return now + (kStep - now.time_since_epoch() % kStep) % kStep; }

 private:
  static constexpr Duration kLate = std::chrono::milliseconds(200);

  static constexpr std::int64_t kLongestPauseUs = 1'000'000;

  Duration period_;
  std::optional<Instant> begin_;
  bool begun_ = false;
  std::int64_t last_us_ = 0;
  Instant due_{};
  Duration ahead_{};  // how far the schedule is ahead of the timestamps
};

}  // namespace copresence::sensor
