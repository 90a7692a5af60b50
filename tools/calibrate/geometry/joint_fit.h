#pragma once

// All cameras and all markers at once: poses and points that agree best with every ray and every depth, each weighed by
// what it is worth. It closes the loops of a rig of many cameras and tells how far its answer can be trusted.
//
// Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/geometry/sighting.h"

namespace copresence::calibration {

struct JointFit {
  std::vector<Rigid3> world_from_camera;
  std::vector<Eigen::Vector3d> marker_in_world;  ///< the middles, by marker; NaN for one that nobody sees
  /// Of the cameras' poses, six per camera: a small move (metres), then a small turn (radians), both in the camera's
  /// own frame. From the sightings' sigmas; the reference camera's rows are 0.
  Eigen::MatrixXd covariance;
  /// What the residuals are, as a multiple of what the sigmas promise: 1 where the noise is as expected.
  double noise_ratio = 1;

  /// Standard deviation, metres, of the place where `camera` puts a point of the world, by the covariance times the
  /// noise ratio: the shift to expect there.
  double expected_shift_m(std::size_t camera, const Eigen::Vector3d& point_in_world) const;
  /// The same of its direction, radians.
  double expected_turn(std::size_t camera) const;
};

/// Gauss-Newton over poses and points, points eliminated, residuals beyond 2.5 sigma weighed down (Huber).
///
/// start      a first pose per camera, such as fit_rigid() gives; that of `reference` is kept.
/// Requires   every camera has sightings; every point (marker and part) is seen by one at least, in front of it.
JointFit fit_jointly(std::span<const Sighting> sightings, std::span<const Rigid3> start,
                     std::size_t reference);

}  // namespace copresence::calibration
