#pragma once

// Finds surfaces that may continue into a hole, from measured cells in eight directions around it.
// Thread: pure functions, safe anywhere.

#include "capture_server/hole_filling/cells.h"

namespace copresence::hole_filling {

/// A plane over the image. `steps` is the plane's value at a cell's middle; 0 means no plane.
struct Plane {
  float steps = 0;
  float slope_x = 0, slope_y = 0;  ///< In steps per pixel.
};

/// The candidate surfaces for the holes of one cell. `near` is set if there are two surfaces.
struct SurfaceCandidates {
  Plane far, near;
  /// Mean colours, 0 to 255. They are valid if there are two candidates and colour is known.
  std::array<float, 3> far_color{}, near_color{};
  bool prefers_near = false;  ///< The choice if neither pixels nor colour decide.
};

/// Finds the candidate surfaces of a cell. `color` may be null.
SurfaceCandidates find_surface_candidates(const Cells& cells, int column, int row, const ColorImage* color);

}  // namespace copresence::hole_filling
