#pragma once

// The times of a frame on this process's clock, if the server's times are plausible.
//
// Thread: a pure function.

#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/clock_offset.h"

namespace copresence::stream {

/// The greatest plausible time from a frame's capture to its arrival, and for a stage. A connection
/// without frames ends sooner.
inline constexpr std::chrono::seconds kOldestBelieved{10};

struct FrameTimes {
  Instant captured_at;  ///< the time of arrival if the server's times are implausible
  /// From the end of encoding to arrival; nothing if the times are implausible.
  std::optional<Duration> wire;

  bool are_believed() const { return wire.has_value(); }
};

/// `captured_at` and `sent_at` are on the server's clock and may have any value; `clock` is its
/// offset to this process's clock. Times are plausible if the frame was captured, sent and received
/// in this order, within kOldestBelieved. Else the frame counts as captured when it arrived.
FrameTimes frame_times(Instant captured_at, Instant sent_at, Instant received_at,
                       const wire::ClockOffset& clock);

}  // namespace copresence::stream
