#pragma once

// Bundle adjustment: finds the camera poses and marker positions that agree best with all
// observations. Each observation is weighted by its expected error. The result includes an estimate
// of its own error. Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/geometry/observation.h"

namespace copresence::calibrate {

struct BundleAdjustment {
  std::vector<Rigid3> world_from_camera;
  std::vector<Eigen::Vector3d>
      marker_in_world;  ///< Marker centres, metres; NaN for a marker that no camera sees.
  /// Covariance of the cameras' poses, from the observations' sigmas. Each camera has six numbers
  /// in its own frame: a rotation vector (radians), then a translation (metres). The reference
  /// camera's rows are 0.
  Eigen::MatrixXd covariance;
  /// Size of the residuals relative to the observations' sigmas: 1 if the noise is as expected.
  double noise_ratio = 1;

  /// Standard deviation (metres) of a world point as `camera` measures it, due to the pose's error.
  double expected_shift_m(std::size_t camera, const Eigen::Vector3d& point_in_world) const;
  /// Standard deviation of the camera's orientation, radians.
  double expected_turn(std::size_t camera) const;
};

/// Levenberg-Marquardt over poses and points, with the points eliminated (Schur complement).
/// Residuals beyond 2.5 sigma get less weight (Huber).
///
/// `start` has an initial pose for each camera, such as fit_rigid() gives. The pose of `reference`
/// does not change.
/// Requires observations of every camera. Every point (marker and part) must lie in front of a
/// camera that sees it.
BundleAdjustment adjust_bundle(std::span<const Observation> observations, std::span<const Rigid3> start,
                               std::size_t reference);

}  // namespace copresence::calibrate
