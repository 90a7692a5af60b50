#pragma once

// The projector of an open camera, switched as a schedule says. Only for this room's own sources.
//
// Thread: as its source.

#include <OpenNI.h>

#include <chrono>
#include <cstdint>

#include "capture_server/sensor/projector_schedule.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::sensor {

class Projector {
 public:
  /// `device` is open and outlives this; `period` is between two of its frames.
  Projector(openni::Device& device, const ProjectorSlot& slot, Duration period)
      : device_(device), schedule_(slot), settles_(2 * period) {}
  /// Leaves it shining, as it was found.
  ~Projector();
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;

  /// The first turn, or the dark before it. Call once, before the others.
  /// Fails  kUnsupported: this camera cannot.
  Result<void> begin();

  /// Switches it where that is due; true when it did. A camera may take its time: 5 to 250 ms have been reported.
  bool obey();

  /// How soon obey() has something to do.
  Duration until_change() const;

  /// Whether a depth picture that this process got at `at` was exposed in this camera's own light: two periods after
  /// the switch at the earliest, since one is exposed and then transferred, and before the turn's end.
  /// Call when it has just come: one that finds this process late with switching off is not.
  bool lit(Instant at) const;

 private:
  bool set(bool shines);

  openni::Device& device_;
  const ProjectorSchedule schedule_;
  const Duration settles_;
  bool shines_ = true;  // cameras begin so
  Instant lit_since_ = Instant::max();
};

}  // namespace copresence::sensor
