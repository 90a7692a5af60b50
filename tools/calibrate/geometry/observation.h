#pragma once

// One camera's measurement of a point: a precise ray and an imprecise depth. At 2 m a Kinect's ray
// has an error below 1 mm, its depth one of 6 mm. So every solver here weights ray and depth
// separately.

#include <Eigen/Core>
#include <cstddef>
#include <limits>

#include "common/frame/depth_unit.h"

namespace copresence::calibrate {

/// Standard deviation of 1/z for a Kinect v1, in 1/m. This value is the same at every depth.
inline constexpr double kSensorSigma = kKinectV1Noise.sigma_steps / kKinectV1Noise.disparity_constant_m;

struct Observation {
  std::size_t camera = 0;
  std::size_t marker = 0;
  int part = 0;                           ///< Part of the marker: 0 is the centre, other numbers are corners.
  Eigen::Vector2d ray{0, 0};              ///< Ray (x, y, 1) in the camera frame, without distortion.
  double z_m = 1;                         ///< Depth along the optical axis, metres; above 0.
  double ray_sigma = 0.25 / 585;          ///< Standard deviation of each coordinate of `ray`.
  double inverse_z_sigma = kSensorSigma;  ///< Standard deviation of 1 / z_m, in 1/m; see kUnknownDepth.

  Eigen::Vector3d point_in_camera() const { return {ray.x() * z_m, ray.y() * z_m, z_m}; }
  double z_sigma_m() const { return inverse_z_sigma * z_m * z_m; }
};

/// Value of `inverse_z_sigma` for a depth that is only a first guess and gets no weight.
inline constexpr double kUnknownDepth = std::numeric_limits<double>::infinity();

}  // namespace copresence::calibrate
