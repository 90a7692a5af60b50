#pragma once

// A frame's times on this process's clock, as far as its server's can be believed.
//
// Thread: a pure function.

#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/clock_offset.h"

namespace copresence::client {

/// How long before its arrival a frame may have been captured, and a stage may have taken. Connections that
/// stand still end sooner.
inline constexpr std::chrono::seconds kOldestBelieved{10};

struct FrameTimes {
  Instant captured_at;           ///< the arrival where the server's times are not believed
  std::optional<Duration> wire;  ///< from the end of encoding to arrival; nothing where they are not believed

  bool are_believed() const { return wire.has_value(); }
};

/// `captured_at` and `sent_at` on the server's clock, which is `clock` away from ours; any values. A frame is
/// captured, sent and received in this order, and not longer than kOldestBelieved before it is received.
/// Times that contradict this say nothing: the frame then counts as captured when it arrived.
FrameTimes frame_times(Instant captured_at, Instant sent_at, Instant received_at,
                       const wire::ClockOffset& clock);

}  // namespace copresence::client
