#pragma once

// The worlds "board" and "still-board": a chessboard in a bare room, so that lenses, and the classical pair of cameras,
// can be tried from picture to lens.

#include "simulation/figure.h"
#include "simulation/furnishing.h"

namespace copresence::simulation {

/// Both boards have 9x6 inner corners.
inline constexpr int kBoardColumns = 9, kBoardRows = 6;
inline constexpr float kMovingSquare = 0.04f, kStillSquare = 0.09f;  // metres

/// A board that camera 0 of kinect_poses() is shown in 24 places, one after the other in a period: near and far, tilted to
/// all sides, in the picture's corners. Its materials are added to `world`.
Figure make_moving_board(Furnishing& world);

/// The bare room with a larger board in its middle that faces cameras 0 and 1 and stays.
Furnishing furnish_still_board();

}  // namespace copresence::simulation
