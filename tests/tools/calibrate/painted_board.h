#pragma once

// A chessboard in many poses in front of a camera with known intrinsics.

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "tests/tools/calibrate/painted_planes.h"
#include "tools/calibrate/intrinsics/board.h"

namespace copresence::calibrate {

inline const CameraModel kIntrinsics{
    320, 240, 290, 291.5, 161.3, 118.2, {0.12, -0.2, 0.0012, -0.0009, 0, 0, 0, 0}};
inline const Board kBoard{Board::Kind::kChessboard, 7, 5, 0.03, 0, ""};

// x right, y down from the first inner corner; a white rim of one square.
inline int chessboard(double x, double y) {
  const int i = static_cast<int>(std::floor(x / kBoard.square_m)),
            j = static_cast<int>(std::floor(y / kBoard.square_m));
  if (i < -2 || j < -2 || i > kBoard.columns || j > kBoard.rows) return -1;
  if (i < -1 || j < -1 || i >= kBoard.columns || j >= kBoard.rows) return 235;
  return (i + j) % 2 == 0 ? 25 : 235;
}

inline Rigid3 place(double x, double y, double z, double pitch, double yaw, double roll = 0) {
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
       Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const Eigen::Vector3d middle(0.5 * kBoard.square_m * (kBoard.columns - 1),
                               0.5 * kBoard.square_m * (kBoard.rows - 1), 0);
  return {turn, Eigen::Vector3d(x, y, z) - turn * middle};
}

inline const std::vector<Rigid3>& places() {
  static const std::vector<Rigid3> kAll{place(0, 0, 0.32, 0, 0),
                                        place(0, 0, 0.38, 0.5, 0),
                                        place(0, 0, 0.38, -0.5, 0.1),
                                        place(0.02, 0, 0.4, 0, 0.6),
                                        place(-0.02, 0, 0.4, 0.1, -0.6),
                                        place(-0.1, -0.07, 0.42, 0.3, 0.3),
                                        place(0.1, -0.07, 0.42, 0.3, -0.3),
                                        place(-0.1, 0.07, 0.42, -0.3, 0.3),
                                        place(0.1, 0.07, 0.42, -0.3, -0.3),
                                        place(0, 0.04, 0.35, 0.2, 0.2, 0.3),
                                        place(0.03, -0.03, 0.36, -0.4, -0.3, -0.4)};
  return kAll;
}

}  // namespace copresence::calibrate
