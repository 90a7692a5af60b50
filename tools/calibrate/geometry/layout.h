#pragma once

// Whether markers lie so that a pose can be found from them, and if not, what to move where.
// Thread: pure functions.

#include <Eigen/Core>
#include <span>
#include <string>

#include "common/result.h"

namespace copresence::calibration {

enum class Form {
  kRigid,   ///< needs points off one line
  kLinear,  ///< needs points off one plane as well
};

struct NamedPoint {
  std::string name;          ///< the marker's, for people
  Eigen::Vector3d position;  ///< metres, in any one frame
};

/// Limits, metres: nearer together, nearer to one line or plane than this, and the depth's noise decides the pose.
inline constexpr double kLeastExtent = 0.6;       ///< greatest distance between two markers
inline constexpr double kLeastOffLine = 0.15;     ///< of the marker farthest from the line that fits best
inline constexpr double kLeastOffPlane = 0.10;    ///< of the marker farthest from the plane that fits best
inline constexpr std::size_t kFewestMarkers = 4;  ///< three would do, but then nothing could show an error

/// points  the markers that two cameras see in common, or that one camera shares with any other.
/// who     begins the sentence: "left and right".
/// Fails   kInvalid: too few, too close together, on a line, or in a plane where `form` minds; the sentence names the
///         marker to move and how far.
Result<void> check_layout(std::span<const NamedPoint> points, Form form, const std::string& who);

}  // namespace copresence::calibration
