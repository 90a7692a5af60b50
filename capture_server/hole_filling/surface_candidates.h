#pragma once

// Candidate surfaces for a hole, from the measured cells around it in eight directions.
// Thread: pure.

#include "capture_server/hole_filling/cells.h"

namespace copresence::hole_filling {

/// A plane over the image: its steps at a cell's middle, and its slopes.
struct Plane {
  float steps = 0;                 ///< 0: no plane
  float slope_x = 0, slope_y = 0;  ///< steps per pixel
};

/// The candidate surfaces for the holes of one cell. `near` is set only if there are two.
struct SurfaceCandidates {
  Plane far, near;
  std::array<float, 3> far_color{},
      near_color{};           ///< mean, of 255; only if there are two and colour is known
  bool prefers_near = false;  ///< the choice if neither pixels nor colour decide
};

/// Examines the surroundings of a cell. `color` may be null.
SurfaceCandidates find_surface_candidates(const Cells& cells, int column, int row, const ColorImage* color);

}  // namespace copresence::hole_filling
