#pragma once

// When a camera's next frame is to be expected: its period and phase from arrivals that jitter, pause and
// drift. Thread: a value.

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

class ArrivalClock {
 public:
  void arrived(Instant now);

  /// Whether it delivers: at least two frames, and the last one not long ago.
  bool is_running(Instant now) const;

  /// Requires at least two arrivals.
  Duration period() const { return period_; }
  Instant expected() const { return phase_ + period_; }  ///< the next frame, by the mean of those before

  /// How late a frame may still be thought to be under way: about three standard deviations of the jitter.
  Duration patience() const;

 private:
  void restart(Instant now);

  int count_ = 0;    // arrivals since the estimate began, up to where it has settled
  int skipped_ = 0;  // intervals in a row of more than one period
  Instant last_{};   // the last arrival
  Instant phase_{};  // where it would have been without jitter
  Duration period_{};
  Duration jitter_{};  // mean distance of arrivals from where they were expected
};

}  // namespace copresence::pacing
