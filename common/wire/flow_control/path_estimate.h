#pragma once

// Estimates what a path to one client is like from the client's acknowledgements: how long it is and how much
// it carries.
//
//   ack delay         = base delay + transmission time + queueing, from sending a frame to its acknowledgement
//   transmission time = bytes of the frame / delivery rate
//
// Delivery rate: bytes between two acknowledgements over the time between them, or over the time between the
// two frames' sending if that was longer, so that acknowledgements which arrive in a bunch do not overstate
// it. It is the largest value of 2 s. A path that is never busy shows only what was sent over it, so only
// samples of a busy path let older ones expire (BBR, Cardwell et al. 2016, section "application-limited").
//
// Base delay: the ack delay of a frame on an empty path, less its transmission time. It is the smallest value
// of the last 10 s, and rises only when a frame that had the path to itself proves it: what other frames of
// ours wait for is a queue and must not become part of the base. When no frame came near the base for 10 s,
// is_stale() asks the sender to let the path run empty once. A keyframe's transmission is overstated where
// the rate is understated, so a base that a keyframe gave holds until a smaller frame takes hardly longer
// than that keyframe did, and for 2 s at most.
//
// Thread: a value.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class PathEstimate {
 public:
  /// Ack delays vary by up to `tolerance` on one path; a frame that came within half of it came near the
  /// base.
  explicit PathEstimate(Duration tolerance) : tolerance_(tolerance) {}

  /// What acknowledged() needs to know of a frame that was sent.
  struct Sent {
    Instant at;
    std::size_t bytes;
    bool alone;  ///< nothing else was in flight
  };

  /// The client has this frame, and it had the frame sent before it earlier.
  void acknowledged(const Sent& frame, Instant now);

  /// Bytes per second; nothing until two frames that were in flight together are acknowledged, or one at
  /// once.
  std::optional<double> delivery_rate() const;
  /// Nothing until the first acknowledgement.
  std::optional<Duration> base_delay() const;
  /// Zero while the delivery rate is unknown.
  Duration transmission_time(std::size_t bytes) const;
  /// How much longer the newest acknowledged frame took than the base and its transmission: queueing and
  /// jitter.
  Duration queueing_delay() const { return queueing_; }
  /// No frame came near the base delay for long.
  bool is_stale(Instant now) const;
  Instant stale_at() const;

 private:
  void measure_rate(const Sent& frame, Instant now);
  void measure_delay(const Sent& frame, Instant now);

  struct RateSample {
    Instant at;
    double bytes_per_second;
  };
  struct DelaySample {
    Duration ack_delay;
    std::size_t bytes;
  };

  Duration tolerance_;
  std::deque<RateSample> rates_;  // falling: the first is the largest
  std::optional<DelaySample> base_;
  bool base_is_of_large_frame_ = false;
  Instant base_seen_at_{};  // the latest frame that came near it
  Duration queueing_{};
  double mean_bytes_ = 0;  // of a frame, over the last few
  std::optional<Sent> previous_;
  Instant previous_acknowledged_at_{};
};

}  // namespace copresence::wire
