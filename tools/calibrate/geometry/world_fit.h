#pragma once

// From what every camera saw of the markers to one world: pairs of cameras that share enough markers, joined to a tree
// from the reference camera, then everything fitted at once; and how good it is, said in four ways.
//
// Thread: pure functions.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/rigid3.h"
#include "common/result.h"
#include "tools/calibrate/geometry/layout.h"
#include "tools/calibrate/geometry/sighting.h"

namespace copresence::calibration {

/// Root mean square and worst of some distances, metres.
struct Spread {
  double rms = 0, worst = 0;
  std::size_t worst_at = 0;  ///< which marker (of a camera) or camera (of a marker)
  std::size_t count = 0;
};

struct CameraFit {
  Rigid3 world_from_camera;
  Spread residual;       ///< where it puts the markers, against where all put them
  Spread leave_one_out;  ///< each marker against where the others put it, fitted without that marker
  double expected_shift_m =
      0;  ///< standard deviation of a point among the markers, against the reference camera
  double expected_turn = 0;  ///< and of directions, radians
};

struct MarkerFit {
  Eigen::Vector3d in_world{0, 0, 0};  ///< NaN where nobody saw it
  Spread residual;                    ///< over the cameras that see it
};

/// Two cameras that share markers enough, each form fitted to this pair alone.
struct PairFit {
  std::size_t a = 0, b = 0, markers = 0;
  bool in_tree = false;
  double rigid_rms_m = 0;
  std::optional<double> linear_rms_m;  ///< of the rigid transform nearest to the linear form; nothing where
  std::string no_linear;               ///< the markers do not allow it, and why
  double least_scale = 1, most_scale = 1;  ///< what the linear form did to lengths
};

struct WorldFit {
  std::vector<CameraFit> cameras;
  std::vector<MarkerFit> markers;
  std::vector<PairFit> pairs;
  double noise_ratio = 1;  ///< residuals as a multiple of the sensor's expected noise
};

struct Names {
  std::vector<std::string> cameras, markers;
};

struct WorldSettings {
  std::size_t reference = 0;  ///< camera
  Rigid3 world_from_reference;
  Form form = Form::kRigid;
  /// The points are of one rigid board, whose size tells their depth far better than a sensor's noise allows: lay-outs
  /// that check_layout() would call too close will do.
  bool is_board = false;
};

/// Fails  kInvalid: a camera shares too few markers with the others, or they lie badly; see check_layout().
Result<WorldFit> fit_world(std::span<const Sighting> sightings, const Names& names,
                           const WorldSettings& settings);

}  // namespace copresence::calibration
