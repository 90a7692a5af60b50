#pragma once

// The surfaces that one camera sees, as points with normals: the input of refinement.
//
// A plane is fitted around each pixel, by linear least squares on 1/z. In the picture of a pin-hole
// camera 1/z of a plane is linear, and the noise of a Kinect is uniform in 1/z. A second pass
// leaves out outliers, and a third one fits a curved surface.
//
// Thread: pure.

#include <Eigen/Core>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"

namespace copresence::calibrate {

struct Surface {
  CameraModel model;
  Image<float> depth_m;           ///< As measured, 0 = none; it marks free space even where no plane fits.
  Image<Eigen::Vector3f> point;   ///< On the fitted plane, metres, camera frame; valid where sigma > 0.
  Image<Eigen::Vector3f> normal;  ///< Length 1, towards the camera.
  Image<float> sigma;  ///< Expected error of the point along the normal, metres; 0 if there is no plane.
  int measured = 0;    ///< pixels with depth
  int planar = 0;      ///< Pixels with a plane.
};

/// depth_m  metres along the optical axis, 0 = none, of the model's size. Depth outside of [near_m,
///          far_m] is ignored.
Surface make_surface(const Image<float>& depth_m, const CameraModel& model, float near_m = 0.4f,
                     float far_m = 5.0f);

}  // namespace copresence::calibrate
