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

  /// `begin`: when the first frame is due; at the next step where none is given, or where it has passed.
  explicit PlaybackSchedule(std::optional<Instant> begin = std::nullopt) : begin_(begin) {}

  /// The instant at which the frame with this timestamp is due, when it is `now`. A pause of more than a second is
  /// shortened to one, a step back counts as none. Whoever comes more than two tenths of a second late (a suspended
  /// process, say) has the rest moved instead of getting a burst of frames.
  Instant due(std::int64_t timestamp_us, Instant now) {
    using std::chrono::microseconds;
    if (!begun_) {
      begun_ = true;
      due_ = begin_ && *begin_ > now ? *begin_ : in_step(now);
    } else {
      due_ += microseconds(std::clamp<std::int64_t>(timestamp_us - last_us_, 0, 1'000'000));
      if (now - due_ > kLate) due_ = now;
    }
    last_us_ = timestamp_us;
    return due_;
  }

 private:
  static constexpr Duration kLate = std::chrono::milliseconds(200);

  static Instant in_step(Instant now) { return now + (kStep - now.time_since_epoch() % kStep) % kStep; }

  std::optional<Instant> begin_;
  bool begun_ = false;
  std::int64_t last_us_ = 0;
  Instant due_{};
};

}  // namespace copresence::sensor
