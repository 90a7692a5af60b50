#pragma once

// The surfaces that one camera sees, as points with normals: what poses are refined on.
//
// Around each pixel a plane is fitted. In the picture of a pin-hole camera a plane is linear in 1/z, and so are a
// Kinect's errors, so the fit is linear least squares on 1/z; a second pass leaves out what lies off the first plane,
// and a third takes the bend of what is rounded into account.
//
// Thread: pure; a value once made.

#include <Eigen/Core>

#include "common/frame/camera_model.h"
#include "common/frame/image.h"

namespace copresence::alignment {

struct Surface {
  CameraModel model;
  Image<float> depth_m;  ///< as measured, 0 = none: it tells what is free space even where no plane fits
  Image<Eigen::Vector3f> point;   ///< on the fitted plane, metres, camera frame; valid where sigma > 0
  Image<Eigen::Vector3f> normal;  ///< length 1, towards the camera
  Image<float> sigma;  ///< expected error of the point along the normal, metres; 0 where there is no plane
  int measured = 0;    ///< pixels with depth
  int planar = 0;      ///< pixels with a plane
};

/// depth_m  metres along the optical axis, 0 = none, of the model's size; what lies beyond [near_m, far_m] is left out.
Surface make_surface(const Image<float>& depth_m, const CameraModel& model, float near_m = 0.4f,
                     float far_m = 5.0f);

}  // namespace copresence::alignment
