#pragma once

// Which surfaces a hole may lie on, judged from the measured cells around it in eight directions.
// Thread: pure.

#include "capture_server/hole_filling/cells.h"

namespace copresence::hole_filling {

/// A plane over the image: steps at a cell's middle, and its slopes.
struct Plane {
  float steps = 0;                 ///< 0: there is none
  float slope_x = 0, slope_y = 0;  ///< steps per pixel
};

/// What the holes of one cell may lie on. `near` only where there are two candidates.
struct SurfaceGuess {
  Plane far, near;
  std::array<float, 3> far_color{},
      near_color{};           ///< mean, of 255; only where there are two and colour is known
  bool prefers_near = false;  ///< what to believe where neither pixels nor colour tell
};

/// Looks around `cell`. `color` may be null.
SurfaceGuess guess_surfaces(const Cells& cells, int column, int row, const ColorImage* color);

}  // namespace copresence::hole_filling
