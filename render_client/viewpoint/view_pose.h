#pragma once

// The pose and projection of one view.

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

struct ViewPose {
  /// A pinhole without distortion. An off-centre principal point means an off-axis projection.
  CameraModel intrinsics;
  Rigid3 world_from_eye;  ///< Metres. The eye's frame has x right, y down and z forward.
  double near_m = 0.1;    ///< Only surfaces between near_m and far_m are drawn.
  double far_m = 10.0;

  friend bool operator==(const ViewPose&, const ViewPose&) = default;
};

}  // namespace copresence::viewpoint
