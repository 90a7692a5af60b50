#pragma once

// What a camera knows of a point that others may see too: the ray to it, precisely, and its depth, roughly. A Kinect's
// depth errs by 6 mm at 2 m, its pictures by less than 1 mm there; every solver here weighs the two accordingly.

#include <Eigen/Core>
#include <cstddef>
#include <limits>

#include "common/frame/depth_unit.h"

namespace copresence::calibration {

/// Standard deviation of 1/z for a Kinect v1, in 1/m; the same at every depth.
inline constexpr double kSensorSigma = kKinectV1Noise.sigma_steps / kKinectV1Noise.disparity_constant_m;

struct Sighting {
  std::size_t camera = 0;
  std::size_t marker = 0;
  int part = 0;                   ///< 0: the marker's middle; others: further points of it, its corners say
  Eigen::Vector2d ray{0, 0};      ///< (x, y) at z = 1, without distortion, camera frame
  double z_m = 1;                 ///< along the optical axis; > 0
  double ray_sigma = 0.25 / 585;  ///< of each coordinate of `ray`
  double inverse_z_sigma = kSensorSigma;  ///< of 1 / z_m, 1/m; infinite where z_m is only a first guess

  Eigen::Vector3d point_in_camera() const { return {ray.x() * z_m, ray.y() * z_m, z_m}; }
  double z_sigma_m() const { return inverse_z_sigma * z_m * z_m; }
};

/// No weight on depth.
inline constexpr double kUnknownDepth = std::numeric_limits<double>::infinity();

}  // namespace copresence::calibration
