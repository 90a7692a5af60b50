#pragma once

// One camera's measurement of a point that other cameras may see too: the ray to it, which is
// precise, and its depth, which is not. At 2 m a Kinect's depth has an error of 6 mm, and its ray
// one of less than 1 mm. So every solver here weights the two separately.

#include <Eigen/Core>
#include <cstddef>
#include <limits>

#include "common/frame/depth_unit.h"

namespace copresence::calibrate {

/// Standard deviation of 1/z for a Kinect v1, in 1/m; the same at every depth.
inline constexpr double kSensorSigma = kKinectV1Noise.sigma_steps / kKinectV1Noise.disparity_constant_m;

struct Observation {
  std::size_t camera = 0;
  std::size_t marker = 0;
  int part = 0;                           ///< 0: the marker's centre; other numbers: its corners.
  Eigen::Vector2d ray{0, 0};              ///< (x, y) at z = 1, without distortion, camera frame.
  double z_m = 1;                         ///< Along the optical axis; > 0.
  double ray_sigma = 0.25 / 585;          ///< Standard deviation of each coordinate of `ray`.
  double inverse_z_sigma = kSensorSigma;  ///< Of 1 / z_m, in 1/m; infinite if z_m is only a first guess.

  Eigen::Vector3d point_in_camera() const { return {ray.x() * z_m, ray.y() * z_m, z_m}; }
  double z_sigma_m() const { return inverse_z_sigma * z_m * z_m; }
};

/// Gives depth no weight.
inline constexpr double kUnknownDepth = std::numeric_limits<double>::infinity();

}  // namespace copresence::calibrate
