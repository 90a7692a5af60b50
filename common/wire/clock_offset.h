#pragma once

// Estimates the offset between the server's and the client's monotonic clock (Cristian 1989). The
// server answers a ping with its time, which is assumed to be the middle of the round trip. So the
// error is at most half the round trip. The best ping has the smallest bound: half its round trip
// plus the possible drift since then. The drift is not estimated, since the error would exceed it.
// Thread: distinct objects are independent.

#include <cstdint>
#include <deque>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

struct ClockOffset {
  Duration offset{};       ///< Server's clock minus client's clock.
  Duration uncertainty{};  ///< Largest possible error of `offset`.

  Instant to_local(Instant server_time) const { return server_time - offset; }
  friend bool operator==(const ClockOffset&, const ClockOffset&) = default;
};

class ClockEstimate {
 public:
  /// Adds a ping. The server's clock showed `server_time` between `sent` and `received` on the
  /// client's clock. Requires sent <= received.
  void add(Instant sent, Instant server_time, Instant received);

  /// Returns the best estimate at `now`. Requires at least one add().
  ClockOffset at(Instant now) const;

 private:
  struct Sample {
    Instant received;
    Duration offset;
    Duration half_round_trip;
  };
  std::deque<Sample> samples_;  // The newest kSamples samples.
};

/// Identifies the monotonic clock of this machine. Processes with the same number share a clock.
/// The number is a hash of the boot id and the time namespace's offsets, or 0 if unknown.
std::uint64_t monotonic_clock_id();

}  // namespace copresence::wire
