#pragma once

// Estimates delay and rate of the network path to one client from the client's acknowledgements.
// The ack delay is the time from sending a frame to its acknowledgement:
//
//   Ack delay = base delay + transmission time + queueing.
//   Transmission time = bytes of the frame / delivery rate.
//
// Delivery rate: a sample is the bytes of a frame divided by the time since the previous
// acknowledgement. If the two frames were sent farther apart, the sample uses the time between
// sending them. Otherwise acknowledgements that arrive together would overstate the rate. The
// estimate is the largest sample of the last 2 s. A path that is not busy shows only the rate of
// sending. So only samples of a busy path make older samples expire (BBR, Cardwell et al. 2016,
// "application-limited").
//
// Base delay: the ack delay of a frame on an empty path, minus its transmission time. A faster
// frame lowers the estimate at once. Only a frame that was alone on the path raises the estimate.
// Otherwise a queue of our own frames would become part of the base delay. If no frame came near
// the base delay for 10 s, is_stale() asks the sender to let the path run empty once.
//
// The first frame is a keyframe. If the sender is slower than the path, the estimated rate is too
// low. The base delay that follows from this rate and the keyframe is then too low as well. The
// first smaller frame that takes no longer than the keyframe corrects both. Thread: distinct
// objects are independent.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class PathEstimate {
 public:
  /// `tolerance` is the normal variation of ack delays. A delay within half of `tolerance` counts
  /// as near.
  explicit PathEstimate(Duration tolerance) : tolerance_(tolerance) {}

  /// Facts about a sent frame that acknowledged() needs.
  struct Sent {
    Instant at;
    std::size_t bytes;
    bool alone;  ///< True if no other frame was in flight.
  };

  /// Reports that the client has this frame. Call this in the order of sending.
  void acknowledged(const Sent& frame, Instant now);

  /// In bytes per second. The rate is known once two frames that were in flight together are
  /// acknowledged, or one frame is acknowledged within half the tolerance.
  std::optional<double> delivery_rate() const;
  /// Empty until the first acknowledgement.
  std::optional<Duration> base_delay() const;
  /// Zero while the delivery rate is unknown.
  Duration transmission_time(std::size_t bytes) const;
  /// Newest ack delay minus base delay and transmission time: queueing and jitter.
  Duration queueing_delay() const { return queueing_; }
  /// True if no frame came near the base delay for 10 s.
  bool is_stale(Instant now) const;
  Instant stale_at() const;

 private:
  void measure_rate(const Sent& frame, Instant now);
  void measure_delay(const Sent& frame, Instant now);

  struct RateSample {
    Instant at;
    double bytes_per_second;
    bool limited_by_path;  // True if acknowledgements came farther apart than the frames were sent.
  };
  struct DelaySample {
    Duration ack_delay;
    std::size_t bytes;
  };

  Duration tolerance_;
  std::deque<RateSample> rates_;  // Sorted by rate: the first is the largest.
  std::optional<DelaySample> base_;
  bool base_is_of_large_frame_ = false;
  Instant base_seen_at_{};  // Time of the latest frame near the base delay.
  Duration queueing_{};
  double mean_bytes_ = 0;  // Mean size of the last few frames.
  std::optional<Sent> previous_;
  Instant previous_acknowledged_at_{};
};

}  // namespace copresence::wire
