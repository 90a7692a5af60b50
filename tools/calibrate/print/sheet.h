#pragma once

// Boards and markers as geometry on paper: black rectangles and text, in millimetres from the page's top left corner. Each
// page has rulers, so that its print can be measured, and the flags to give when it is used. Thread: pure functions.

#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/calibrate/lens/board.h"

namespace copresence::calibrate {

struct Paper {
  std::string name;                      ///< for people
  double shorter_mm = 0, longer_mm = 0;  ///< sides
};

inline const Paper kA4{"A4", 210, 297}, kA3{"A3", 297, 420};

/// x right, y down.
struct Rectangle {
  double x, y, width, height;
};

struct Text {
  double x, y;       ///< left end of the base line
  double height_mm;  ///< of the font
  std::string text;  ///< ASCII
};

struct Page {
  std::vector<Rectangle> black;
  std::vector<Text> texts;
};

struct Sheet {
  double width_mm = 0, height_mm = 0;
  std::vector<Page> pages;
  std::string content;  ///< "chessboard, 9x6 inner corners, squares of 25 mm"
  std::string flags;    ///< of `calibrate` for its use
};

/// A chessboard or ChArUco board on one page. If its square is 0, the square takes the largest whole millimetres that fit. If
/// its marker is 0, the marker takes about three quarters of a square.
/// Fails  kInvalid for what does not fit on the paper, saying what does, and as problem_of().
Result<Sheet> board_sheet(Board board, const Paper& paper);

/// One marker per page, with a white rim of at least a cell. A side of 0 stands for the largest whole centimetres that fit.
/// Fails  kInvalid for a number that the dictionary does not have, and for a side that does not fit. Requires a dictionary
///        that there is.
Result<Sheet> marker_sheet(const std::string& dictionary, int border_bits, std::span<const int> numbers,
                           double side_m, const Paper& paper);

}  // namespace copresence::calibrate
