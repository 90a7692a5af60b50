#pragma once

// Estimates the offset between the server's and the client's monotonic clock (Cristian 1989). The
// server answers a ping with its time. That time is assumed at the middle of the round trip, so the
// error is at most half the round trip. The best ping has the smallest bound: half its round trip
// plus the possible drift since then. The drift itself is not estimated: over the age of a ping,
// the error of an estimate would exceed the drift. Thread: values.

#include <cstdint>
#include <deque>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

struct ClockOffset {
  Duration offset{};       ///< server's clock minus client's clock
  Duration uncertainty{};  ///< the true offset differs by at most this

  Instant to_local(Instant server_time) const { return server_time - offset; }
  friend bool operator==(const ClockOffset&, const ClockOffset&) = default;
};

class ClockEstimate {
 public:
  /// Adds a ping: the server's clock showed `server_time` between `sent` and `received` on the
  /// client's clock. Requires sent <= received.
  void add(Instant sent, Instant server_time, Instant received);

  /// The best estimate at `now`. Requires at least one add().
  ClockOffset at(Instant now) const;

 private:
  struct Sample {
    Instant received;
    Duration offset;
    Duration half_round_trip;
  };
  std::deque<Sample> samples_;  // the newest kSamples
};

/// Identifies the monotonic clock of this machine: two processes with the same number use the same
/// clock. It is a hash of the kernel's boot id and the time namespace's offsets; 0 if they are
/// unknown.
std::uint64_t monotonic_clock_id();

}  // namespace copresence::wire
