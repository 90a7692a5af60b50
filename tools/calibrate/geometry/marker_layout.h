#pragma once

// Checks whether a pose can be found from a layout of markers. If not, it says which marker to move
// and how far. Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

enum class Solver {
  kRigid,   ///< Rigid fit; needs points that are not on one line.
  kLinear,  ///< Linear fit; needs points that are not in one plane.
};

struct NamedPoint {
  std::string name;
  Eigen::Vector3d position;  ///< Position in metres, in any frame.
};

/// Minimum extents of a layout, metres. In a smaller layout, depth noise makes poses too
/// inaccurate.
inline constexpr double kLeastExtent = 0.6;       ///< Greatest distance between two markers.
inline constexpr double kLeastOffLine = 0.15;     ///< Distance of the farthest marker from the best line.
inline constexpr double kLeastOffPlane = 0.10;    ///< Distance of the farthest marker from the best plane.
inline constexpr std::size_t kFewestMarkers = 4;  ///< Three markers determine a pose, but leave no residual.

/// `points` are the markers that two cameras see in common, or that one camera shares with any
/// other.
/// `cameras` names the cameras at the beginning of a message: "left and right".
/// Fails with kInvalid if there are too few markers, or if they are too close together or on a
/// line. With the linear solver, also fails so if they are in a plane.
Result<void> check_layout(std::span<const NamedPoint> points, Solver solver, const std::string& cameras);

}  // namespace copresence::calibrate
