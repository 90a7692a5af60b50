#pragma once

// Switches the projector of an open camera by a schedule. PrimeSense's and Asus's cameras can
// switch their projector; a Kinect v1 cannot.
// Thread: the thread that reads the camera.

#include <OpenNI.h>

#include <chrono>
#include <cstdint>

#include "capture_server/sensor/projector_schedule.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::sensor {

class Projector {
 public:
  /// `device` is open and outlives this object. `period` is the time between two frames.
  Projector(openni::Device& device, const ProjectorSlot& slot, Duration period)
      : device_(device), schedule_(slot), settles_(2 * period) {}
  /// Switches the projector on, because it was on at the start.
  ~Projector();
  Projector(const Projector&) = delete;
  Projector& operator=(const Projector&) = delete;

  /// Begins to follow the schedule. Call begin() once, before the other functions.
  /// Fails with kUnsupported if the camera cannot switch its projector.
  Result<void> begin();

  /// Switches the projector if the schedule requires it, and then returns true. According to
  /// reports, cameras need 5 to 250 ms to switch.
  bool follow_schedule();

  /// Time until follow_schedule() has to be called again.
  Duration until_change() const;

  /// True if a depth picture received at `at` was exposed while this camera's projector was on. A
  /// picture is exposed and then transferred, so the first such picture arrives two periods after
  /// the projector was switched on. The last such picture arrives at the end of the time slot. Call
  /// this function on arrival of the picture, since the result depends on the present time.
  bool is_exposed(Instant at) const;

 private:
  bool set(bool on);

  openni::Device& device_;
  const ProjectorSchedule schedule_;
  const Duration settles_;
  bool is_on_ = true;  // Cameras are opened with the projector on.
  Instant exposed_since_ = Instant::max();
};

}  // namespace copresence::sensor
