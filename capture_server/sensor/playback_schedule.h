#pragma once

// When each frame of a recording is due, on a clock that does not drift: from its timestamps and one starting
// instant, never from when the frame before it was shown.
//
// Replays that nobody gave an instant begin on whole fifths of a second of the machine's clock: cameras of the common
// rates then deliver in step, as cameras do that are wired together, whenever each replay was started. Their views wait for
// no straggler, and what is measured does not hang on chance.
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

  /// `period`: a frame's usual time, for where the recording's times say nothing. `begin`: when the first frame is due; at
  /// the next step where none is given, or where it has passed.
  explicit PlaybackSchedule(Duration period, std::optional<Instant> begin = std::nullopt)
      : period_(period), begin_(begin) {}

  /// The instant at which the frame with this timestamp is due, when it is `now`. A pause of more than a second is
  /// shortened to one. Frames whose times stand still or go back follow each other by the period; what that puts them
  /// ahead of the recording's times, up to a second, the next steps forward are shortened by, but not below the period.
  /// Whoever comes more than two tenths of a second late (a suspended process, say) has the rest moved instead of
  /// getting a burst of frames.
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
  Duration ahead_{};  // of the recording's times, since they stood still
};

}  // namespace copresence::sensor
