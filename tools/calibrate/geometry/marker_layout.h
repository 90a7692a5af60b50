#pragma once

// Checks whether a pose can be found from a layout of markers. If not, it says which marker to move
// and how far. Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::calibrate {

enum class Solver {
  kRigid,   ///< Needs points that are not on one line.
  kLinear,  ///< Needs points that are not in one plane either.
};

struct NamedPoint {
  std::string name;          ///< The marker's name, for messages.
  Eigen::Vector3d position;  ///< metres, in any frame.
};

/// Limits of a layout, metres. In a smaller layout the noise of depth dominates the pose.
inline constexpr double kLeastExtent = 0.6;     ///< Greatest distance between two markers.
inline constexpr double kLeastOffLine = 0.15;   ///< Of the farthest marker from the line that fits best.
inline constexpr double kLeastOffPlane = 0.10;  ///< Of the farthest marker from the plane that fits best.
inline constexpr std::size_t kFewestMarkers =
    4;  ///< Three determine a pose, but leave no residual to judge it by.

/// points   the markers that two cameras see in common, or that one camera shares with any other.
/// cameras  names the cameras at the beginning of a message: "left and right".
/// Fails    kInvalid: too few markers, too close together, on a line, or in a plane if the solver
///          is linear.
Result<void> check_layout(std::span<const NamedPoint> points, Solver solver, const std::string& cameras);

}  // namespace copresence::calibrate
