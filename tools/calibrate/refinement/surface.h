#pragma once

// The surfaces that one camera sees, as points with normals: the input of refinement.
// A plane is fitted around each pixel, by linear least squares on 1/z. In a pinhole camera's
// picture 1/z of a plane is linear, and the noise of a Kinect is uniform in 1/z. A second pass
// leaves out outliers, and a third pass fits a curved surface. Thread: pure functions.

#include <Eigen/Core>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"

namespace copresence::calibrate {

struct Surface {
  CameraModel model;
  Image<float> depth_m;           ///< Measured depth, 0 = none; marks free space even where no plane fits.
  Image<Eigen::Vector3f> point;   ///< Point on the fitted plane, metres, camera frame; valid where sigma > 0.
  Image<Eigen::Vector3f> normal;  ///< Unit normal that points towards the camera.
  Image<float> sigma;  ///< Expected error of the point along the normal, metres; 0 if there is no plane.
  int measured = 0;    ///< Number of pixels with depth.
  int planar = 0;      ///< Number of pixels with a plane.
};

/// `depth_m` is in metres along the optical axis, 0 for none, and has the model's size. Depth
/// outside of [near_m, far_m] is ignored.
Surface make_surface(const Image<float>& depth_m, const CameraModel& model, float near_m = 0.4f,
                     float far_m = 5.0f);

}  // namespace copresence::calibrate
