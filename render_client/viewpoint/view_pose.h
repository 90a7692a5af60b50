#pragma once

// Pose and projection of one view.
// Thread: a value.

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

struct ViewPose {
  CameraModel intrinsics;  ///< pin-hole without distortion; an off-centre cx, cy is an off-axis projection
  Rigid3 world_from_eye;   ///< metres; the eye's frame is a camera's: x right, y down, z forward
  double near_m = 0.1;     ///< only surfaces between near_m and far_m are drawn
  double far_m = 10.0;

  friend bool operator==(const ViewPose&, const ViewPose&) = default;
};

}  // namespace copresence::viewpoint
