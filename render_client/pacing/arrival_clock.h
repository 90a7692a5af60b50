#pragma once

// Predicts when a camera's next frame will arrive. It estimates period and phase of the arrivals
// despite jitter, pauses and drift. Thread: different objects may be used at the same time.

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

class ArrivalClock {
 public:
  void arrived(Instant now);

  /// Returns whether the camera delivers frames: at least two have arrived, the last one recently.
  bool is_running(Instant now) const;

  /// Requires at least two arrivals.
  Duration period() const { return period_; }
  Instant expected() const { return phase_ + period_; }  ///< Predicted arrival of the next frame.

  /// Returns how long to wait for a late frame: about three standard deviations of the jitter.
  Duration patience() const;

 private:
  void restart(Instant now);

  int count_ = 0;    // Number of arrivals since the estimate began, at most kSettledCount.
  int skipped_ = 0;  // Number of consecutive intervals longer than one period.
  Instant last_{};
  Instant phase_{};  // The last arrival without its jitter.
  Duration period_{};
  Duration jitter_{};  // Mean absolute error of the predicted arrivals.
};

}  // namespace copresence::pacing
