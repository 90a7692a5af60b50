#pragma once

// Boards and markers on paper: black rectangles and text, in millimetres from the page's top left
// corner. Each page has rulers for checking the print, and shows the `calibrate` flags for its use.
// Thread: pure functions.

#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/calibrate/intrinsics/board.h"

namespace copresence::calibrate {

struct Paper {
  std::string name;  ///< Name for messages.
  double shorter_mm = 0, longer_mm = 0;
};

inline const Paper kA4{"A4", 210, 297}, kA3{"A3", 297, 420};

/// X is right, y is down.
struct Rectangle {
  double x, y, width, height;
};

struct Text {
  double x, y;  ///< Left end of the base line.
  double height_mm;
  std::string text;  ///< Text in ASCII.
};

struct Page {
  std::vector<Rectangle> black;
  std::vector<Text> texts;
};

struct Sheet {
  double width_mm = 0, height_mm = 0;
  std::vector<Page> pages;
  std::string content;  ///< Such as "chessboard, 9x6 inner corners, squares of 25 mm".
  std::string flags;    ///< The `calibrate` command that uses the sheet.
};

/// A chessboard or ChArUco board on one page. If `square_m` is 0, uses the largest whole number of
/// millimetres that fits. If `marker_m` is 0, uses about three quarters of a square.
/// Fails with kInvalid if the board does not fit on the paper, or if problem_of() rejects it.
Result<Sheet> board_sheet(Board board, const Paper& paper);

/// Prints one marker per page, with a white rim of at least one cell. A side of 0 means the largest
/// whole number of centimetres that fits. Requires a known dictionary.
/// Fails with kInvalid for a number that is not in the dictionary, and for a side that does not
/// fit.
Result<Sheet> marker_sheet(const std::string& dictionary, int border_bits, std::span<const int> numbers,
                           double side_m, const Paper& paper);

/// A PDF 1.4 file, uncompressed: rectangles at exact millimetres, and text in Helvetica. Asks
/// viewers to print without scaling.
std::string to_pdf(const Sheet& sheet);

}  // namespace copresence::calibrate
