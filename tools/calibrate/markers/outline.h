#pragma once

// Corners of a dark square on white to a tenth of a pixel or two, also where it is seen from the side: each side is a line
// through where dark turns to light, and corners are where sides cross. A detector's corners, even refined by their own
// neighbourhood, err by several pixels there. Thread: pure functions.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "common/frame/image.h"

namespace copresence::calibrate {

/// Moves corners (pixels, in order around the square) to where the sides cross. False where no four sides are found near
/// them; the corners are then worth nothing.
bool refine_outline(const Image<std::uint8_t>& picture, std::array<Eigen::Vector2d, 4>& corners);

}  // namespace copresence::calibrate
