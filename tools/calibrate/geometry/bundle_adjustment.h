#pragma once

// Bundle adjustment: the poses of all cameras and the positions of all markers that agree best with
// all observations, each weighted by its expected error. It closes the loops of a rig of many
// cameras, and estimates its own error.
//
// Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/geometry/observation.h"

namespace copresence::calibrate {

struct BundleAdjustment {
  std::vector<Rigid3> world_from_camera;
  std::vector<Eigen::Vector3d>
      marker_in_world;  ///< centres, by marker; NaN for a marker that no camera sees.
  /// Covariance of the cameras' poses, from the observations' sigmas. Six numbers per camera, in
  /// the camera's own frame: a rotation vector (radians), then a translation (metres). The
  /// reference camera's rows are 0.
  Eigen::MatrixXd covariance;
  /// Size of the residuals relative to the observations' sigmas: 1 if the noise is as expected.
  double noise_ratio = 1;

  /// Standard deviation, metres, of the position that `camera` gives to a point of the world: by
  /// the covariance and the noise ratio.
  double expected_shift_m(std::size_t camera, const Eigen::Vector3d& point_in_world) const;
  /// The same for the camera's orientation, radians.
  double expected_turn(std::size_t camera) const;
};

/// Levenberg-Marquardt over poses and points, with the points eliminated (Schur complement).
/// Residuals beyond 2.5 sigma get less weight (Huber).
///
/// start      an initial pose per camera, such as fit_rigid() gives. The pose of `reference` does
///            not change.
/// Requires   observations of every camera; every point (marker and part) lies in front of a camera
///            that sees it.
BundleAdjustment adjust_bundle(std::span<const Observation> observations, std::span<const Rigid3> start,
                               std::size_t reference);

}  // namespace copresence::calibrate
