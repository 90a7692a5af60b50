#pragma once

// Converts the times of a frame to this process's clock, if the server's times are plausible.
// Thread: pure functions.

#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/clock_offset.h"

namespace copresence::stream {

/// The greatest plausible time from a frame's capture to its arrival, and for a stage.
inline constexpr std::chrono::seconds kOldestBelieved{10};

struct FrameTimes {
  Instant captured_at;  ///< The time of arrival if the server's times are implausible.
  /// Time from the end of encoding to arrival, or nothing if the server's times are implausible.
  std::optional<Duration> wire;

  bool are_believed() const { return wire.has_value(); }
};

/// Converts the times. `captured_at` and `sent_at` are on the server's clock and may have any
/// value. `clock` is its offset from this process's clock. Times are plausible if the frame was
/// captured, sent and received in this order, within kOldestBelieved.
FrameTimes frame_times(Instant captured_at, Instant sent_at, Instant received_at,
                       const wire::ClockOffset& clock);

}  // namespace copresence::stream
