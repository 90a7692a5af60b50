#pragma once

// The projector of an open camera, switched by a schedule. PrimeSense's and Asus's cameras can
// switch it, a Kinect v1 cannot.
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
  /// `device` is open and outlives this; `period` is the time between two of its frames.
  Projector(openni::Device& device, const ProjectorSlot& slot, Duration period)
      : device_(device), schedule_(slot), settles_(2 * period) {}
  /// Leaves it on, as it was found.
  ~Projector();
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;

  /// Begins to follow the schedule. Call once, before the others.
  /// Fails  kUnsupported: the camera cannot switch its projector.
  Result<void> begin();

  /// Switches the projector if the schedule requires it; true if it did. A camera takes 5 to 250
  /// ms, by reports.
  bool follow_schedule();

  /// Time until follow_schedule() has to switch.
  Duration until_change() const;

  /// Whether a depth picture that was received at `at` was exposed in this camera's own light. A
  /// picture is exposed and then transferred, so that begins two periods after the projector was
  /// switched on. It ends with the time slot. Call on arrival of the picture: the answer also
  /// depends on the present time.
  bool is_exposed(Instant at) const;

 private:
  bool set(bool on);

  openni::Device& device_;
  const ProjectorSchedule schedule_;
  const Duration settles_;
  bool is_on_ = true;  // as cameras are when they are opened
  Instant exposed_since_ = Instant::max();
};

}  // namespace copresence::sensor
