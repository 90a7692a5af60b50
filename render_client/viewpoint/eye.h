#pragma once

// One eye of the viewer: where it is, and which pixels of the display it sees. Thread: values and pure
// functions.

#include <limits>

#include "common/frame/rigid3.h"
#include "render_client/viewpoint/view_pose.h"

namespace copresence::viewpoint {

/// A grid of pixels of the display. Pixel (i, j) of the eye's picture shows what the display shows at
/// column first_column + i column_step and row first_row + j row_step.
struct PixelGrid {
  int column_step = 1, row_step = 1;
  double first_column = 0, first_row = 0;

  friend bool operator==(const PixelGrid&, const PixelGrid&) = default;
};

struct Eye {
  Rigid3 head_from_eye;  ///< Metres. The identity is the middle of the head.
  /// Distance of the screen from the head, metres. Both eyes see a point at this distance in the same
  /// pixel of the display.
  double screen_distance_m = std::numeric_limits<double>::infinity();
  PixelGrid pixels{};
};

/// Returns the pose and projection of an eye of this head. The view of `head` fills the display. The
/// eye's projection is off-axis, so that the screen is the same for all eyes. Requires a
/// head_from_eye without rotation or with an infinite screen_distance_m.
ViewPose pose_of_eye(const ViewPose& head, const Eye& eye);

}  // namespace copresence::viewpoint
