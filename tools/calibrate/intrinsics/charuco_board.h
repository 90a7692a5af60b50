#pragma once

// Finds the inner corners of a ChArUco board in a picture. Thread: pure functions.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tools/calibrate/intrinsics/board.h"

namespace copresence::calibrate {

/// Corners in pixels, and their numbers: row by row from the top left inner corner.
struct CharucoCorners {
  std::vector<cv::Point2f> pixels;
  std::vector<int> numbers;
  CharucoLayout layout = CharucoLayout::kBlackCorner;  ///< The layout that fits the picture.
};

/// Requires a ChArUco board. Returns no corners if the picture does not show it.
CharucoCorners find_charuco(const Board& board, const cv::Mat& gray);

/// Does what describe_other_board() does, for a ChArUco board.
std::string describe_other_charuco(const Board& board, const ColorImage& picture);

}  // namespace copresence::calibrate
