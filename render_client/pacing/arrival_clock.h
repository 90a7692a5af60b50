#pragma once

// Predicts when a camera's next frame will arrive. It estimates period and phase from arrivals that
// jitter, pause and drift.
//
// Thread: a value.

#include "common/frame/rgbd_frame.h"

namespace copresence::pacing {

class ArrivalClock {
 public:
  void arrived(Instant now);

  /// Whether the camera delivers frames: at least two have come, the last one recently.
  bool is_running(Instant now) const;

  /// Requires at least two arrivals.
  Duration period() const { return period_; }
  Instant expected() const { return phase_ + period_; }  ///< predicted arrival of the next frame

  /// How long a late frame is waited for: about three standard deviations of the jitter.
  Duration patience() const;

 private:
  void restart(Instant now);

  int count_ = 0;    // arrivals since the estimate began; stops at kSettledCount
  int skipped_ = 0;  // consecutive intervals of more than one period
  Instant last_{};   // the last arrival
  Instant phase_{};  // the last arrival without its jitter
  Duration period_{};
  Duration jitter_{};  // mean distance of arrivals from their predictions
};

}  // namespace copresence::pacing
