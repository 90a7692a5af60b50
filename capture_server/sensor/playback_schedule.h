#pragma once

// Computes when each frame of a recording is due. The schedule uses the timestamps and one starting
// instant, but never the time at which a frame was shown, so it does not drift.
//
// By default, a replay begins at a whole fifth of a second of the machine's clock. So replays of
// the common frame rates are in phase, like cameras with a common trigger. Viewers then need not
// wait for the latest frame, and measurements are repeatable.
//
// Thread: one thread at a time per object.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

class PlaybackSchedule {
 public:
  /// A whole number of frame periods at 5, 10, 15, 25, 30 and 60 Hz.
  static constexpr Duration kStep = std::chrono::milliseconds(200);

  /// `period` is the usual time between frames, for recordings with unusable timestamps. `begin` is
  /// the instant at which the first frame is due. If `begin` is missing or has passed, the first
  /// frame is due at the next whole step.
  explicit PlaybackSchedule(Duration period, std::optional<Instant> begin = std::nullopt)
      : period_(period), begin_(begin) {}

  /// Returns the instant at which the frame with this timestamp is due. `now` is the present time.
  /// A pause of more than a second is shortened to one second. If timestamps stand still or
  /// decrease, frames follow each other by the period. The schedule is then ahead of the
  /// timestamps. Up to a second of that lead is taken from later steps, which stay at least one
  /// period long. If a call comes more than 0.2 s late, the remaining schedule is shifted, so that
  /// no burst of frames follows.
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

  static Instant in_sync(Instant now) { return now + (kStep - now.time_since_epoch() % kStep) % kStep; }

 private:
  static constexpr Duration kLate = std::chrono::milliseconds(200);

  static constexpr std::int64_t kLongestPauseUs = 1'000'000;

  Duration period_;
  std::optional<Instant> begin_;
  bool begun_ = false;
  std::int64_t last_us_ = 0;
  Instant due_{};
  Duration ahead_{};  // How far the schedule is ahead of the timestamps.
};

}  // namespace copresence::sensor
