#pragma once

// When each frame of a recording is due, on a clock that does not drift: from its timestamps and one starting
// instant, never from when the frame before it was shown.
//
// Thread: a value.

#include <algorithm>
#include <cstdint>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

class PlaybackSchedule {
 public:
  /// `begin`: when the first frame is due; at once where none is given, or where it has passed.
  explicit PlaybackSchedule(std::optional<Instant> begin = std::nullopt) : begin_(begin) {}

  /// The instant at which the frame with this timestamp is due, when it is `now`. A pause of more than a second is
  /// shortened to one, a step back counts as none. Whoever comes more than two tenths of a second late (a suspended
  /// process, say) has the rest moved instead of getting a burst of frames.
  Instant due(std::int64_t timestamp_us, Instant now) {
    using std::chrono::microseconds;
    if (!begun_) {
      begun_ = true;
      due_ = std::max(now, begin_.value_or(now));
    } else {
      due_ += microseconds(std::clamp<std::int64_t>(timestamp_us - last_us_, 0, 1'000'000));
      if (now - due_ > kLate) due_ = now;
    }
    last_us_ = timestamp_us;
    return due_;
  }

 private:
  static constexpr Duration kLate = std::chrono::milliseconds(200);

  std::optional<Instant> begin_;
  bool begun_ = false;
  std::int64_t last_us_ = 0;
  Instant due_{};
};

}  // namespace copresence::sensor
