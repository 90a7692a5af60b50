#pragma once

// Finds the poses of all cameras from their observations of markers, and estimates the errors.
// Each pair of cameras that shares enough markers is first fitted alone. A tree of pairs from the
// reference camera gives initial poses. A bundle adjustment then fits all cameras together.
// Thread: pure functions.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/geometry/marker_layout.h"
#include "tools/calibrate/geometry/observation.h"

namespace copresence::calibrate {

/// Root mean square and maximum of a set of distances, metres.
struct Spread {
  double rms = 0, worst = 0;
  std::size_t worst_at = 0;  ///< Index of the worst marker (for a camera) or camera (for a marker).
  std::size_t count = 0;
};

struct CameraFit {
  Rigid3 world_from_camera;
  Spread residual;  ///< Distances of the camera's markers from their fitted positions.
  /// Distances between the markers as this camera measures them and as the other cameras do, each
  /// with the marker left out of the fit.
  Spread leave_one_out;
  /// Standard deviation of a point among the markers, metres, relative to the reference camera.
  double expected_shift_m = 0;
  double expected_turn = 0;  ///< Standard deviation of the orientation, radians.
};

struct MarkerFit {
  Eigen::Vector3d in_world{0, 0, 0};  ///< Position, metres; NaN if no camera sees the marker.
  Spread residual;                    ///< Distances over the cameras that see the marker.
};

/// Two cameras that share enough markers, and the fits to this pair alone.
struct PairFit {
  std::size_t a = 0, b = 0, markers = 0;
  bool in_tree = false;
  double rigid_rms_m = 0;
  /// Residual of the rigid transform nearest to the linear solution. Empty if the markers do not
  /// allow the linear solver.
  std::optional<double> linear_rms_m;
  std::string no_linear;                   ///< Reason why the linear solver cannot be used, or empty.
  double least_scale = 1, most_scale = 1;  ///< Smallest and largest scale of LinearFit.
};

struct WorldFit {
  std::vector<CameraFit> cameras;
  std::vector<MarkerFit> markers;
  std::vector<PairFit> pairs;
  double noise_ratio = 1;  ///< Size of the residuals relative to the sensor's expected noise.
};

/// Names of all cameras and markers, by index.
struct RigNames {
  std::vector<std::string> cameras, markers;
};

struct WorldSettings {
  std::size_t reference = 0;
  Rigid3 world_from_reference;
  Solver solver = Solver::kRigid;
  /// True if the points are corners of one rigid board. Depth from the board's known size is more
  /// accurate than a sensor's, so the layout may be smaller than check_layout() requires.
  bool is_board = false;
};

/// Fails with kInvalid if a camera shares too few markers, or if their layout is bad
/// (check_layout()).
Result<WorldFit> fit_world(std::span<const Observation> observations, const RigNames& names,
                           const WorldSettings& settings);

}  // namespace copresence::calibrate
