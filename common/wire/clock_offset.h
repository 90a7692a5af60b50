#pragma once

// The server's monotonic clock seen from the client's. A ping that came back after `round_trip` says what the
// server's clock read somewhere within it: its middle is wrong by at most half of it. The best ping is the
// one with the smallest bound, counting that two clocks drift apart while it ages (Cristian 1989). No slope
// is estimated: over the age that a ping may reach, its error would exceed the drift.
//
// Thread: values.

#include <cstdint>
#include <deque>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

struct ClockOffset {
  Duration offset{};       ///< server's clock minus client's
  Duration uncertainty{};  ///< the true offset lies within +- this

  Instant to_local(Instant server_time) const { return server_time - offset; }
  friend bool operator==(const ClockOffset&, const ClockOffset&) = default;
};

class ClockEstimate {
 public:
  /// The server's clock read `server_time` between `sent` and `received` on the client's. Requires sent <=
  /// received.
  void add(Instant sent, Instant server_time, Instant received);

  /// The best estimate at `now`. Requires at least one add().
  ClockOffset at(Instant now) const;

 private:
  struct Sample {
    Instant received;
    Duration offset;
    Duration half_round_trip;
  };
  std::deque<Sample> samples_;  // the latest kSamples
};

/// Identifies the monotonic clock of this machine: two processes that get the same number read one clock.
/// Made from the kernel's boot id and the time namespace's offsets; 0 where the kernel does not say.
std::uint64_t monotonic_clock_id();

}  // namespace copresence::wire
