#pragma once

// Estimates delay and rate of the network path to one client from the client's acknowledgements.
//
//   ack delay = base delay + transmission time + queueing; from sending a frame to its acknowledgement
//   transmission time = bytes of the frame / delivery rate
//
// Delivery rate: a sample is the bytes of a frame over the time since the previous acknowledgement.
// If the two frames were sent farther apart than that, the sample uses the time between sending
// them: acknowledgements that arrive in a bunch must not overstate the rate. The estimate is the
// largest sample of 2 s. A path that is not busy shows only the rate of sending, so only samples of
// a busy path let older ones expire (BBR, Cardwell et al. 2016, "application-limited").
//
// Base delay: the ack delay of a frame on an empty path, less its transmission time. The estimate
// falls at once when a frame was faster. It rises only when a frame that was alone on the path took
// longer. Otherwise a queue of our own frames would become part of the base delay. When no frame
// came near the base delay for 10 s, is_stale() asks the sender to let the path run empty once.
//
// The first frame is a keyframe. If sending limits the delivery rate, the rate is understated, and
// so is the base delay that this keyframe gave. The first smaller frame that takes no longer than
// the keyframe corrects it. Thread: a value.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class PathEstimate {
 public:
  /// `tolerance`: the variation of ack delays that is normal on one path. A frame within half of it
  /// came near the base delay.
  explicit PathEstimate(Duration tolerance) : tolerance_(tolerance) {}

  /// Facts about a sent frame that acknowledged() needs.
  struct Sent {
    Instant at;
    std::size_t bytes;
    bool alone;  ///< nothing else was in flight
  };

  /// The client has this frame. Call in the order of sending.
  void acknowledged(const Sent& frame, Instant now);

  /// Bytes per second. Nothing until two frames that were in flight together are acknowledged, or
  /// one frame was acknowledged within half the tolerance.
  std::optional<double> delivery_rate() const;
  /// Nothing until the first acknowledgement.
  std::optional<Duration> base_delay() const;
  /// Zero while the delivery rate is unknown.
  Duration transmission_time(std::size_t bytes) const;
  /// Ack delay of the newest acknowledged frame, less base delay and transmission time: queueing
  /// and jitter.
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
    bool limited_by_path;  // acknowledgements came farther apart than the frames were sent
  };
  struct DelaySample {
    Duration ack_delay;
    std::size_t bytes;
  };

  Duration tolerance_;
  std::deque<RateSample> rates_;  // falling: the first is the largest
  std::optional<DelaySample> base_;
  bool base_is_of_large_frame_ = false;
  Instant base_seen_at_{};  // of the latest frame near the base delay
  Duration queueing_{};
  double mean_bytes_ = 0;  // of the last few frames
  std::optional<Sent> previous_;
  Instant previous_acknowledged_at_{};
};

}  // namespace copresence::wire
