#pragma once

// Scenes for tests of calibration: a bare room with ArUco markers or with a chessboard. The true
// poses are known, so a test can go all the way from pictures to poses.
// Thread: free functions, safe anywhere.

#include <Eigen/Core>
#include <vector>

#include "simulation/scene/scene.h"

namespace copresence::simulation {

/// The empty room of all these worlds.
Scene make_bare_room();

/// The black square of a marker: center +- half_u +- half_v, in metres, in the world frame. Seen
/// from its front, u points right and v points down.
struct PlacedMarker {
  int id = 0;  ///< Id in OpenCV's dictionary DICT_4X4_50.
  Eigen::Vector3f center, half_u, half_v;
};

/// The markers of the world "markers", in order of their ids. Six markers hang at different heights
/// and distances and face cameras 0 and 1. Six markers on the backs of the first six face cameras 2
/// and 3. Four markers lie on boxes where all cameras see them.
std::vector<PlacedMarker> placed_markers();

Scene make_marker_room();

/// Both chessboards have 9x6 inner corners.
inline constexpr int kBoardColumns = 9, kBoardRows = 6;
inline constexpr float kMovingSquare = 0.04f, kStillSquare = 0.09f;  // In metres.

/// The chessboard of the world "board". In each period of motion the board takes 24 poses in front
/// of camera 0. The poses are near and far, tilted in all directions, and in the corners of the
/// picture. The function adds the board's materials to `scene`.
Figure make_moving_board(Scene& scene);

/// The world "still-board": a larger chessboard in the room's middle that faces cameras 0 and 1.
Scene make_still_board_room();

}  // namespace copresence::simulation
