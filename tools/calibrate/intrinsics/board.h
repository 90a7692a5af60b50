#pragma once

// Finds a calibration board in a picture: a chessboard, or a chessboard with ArUco markers in its
// white squares (ChArUco). A ChArUco board may be partly visible. Thread: pure functions.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

struct Board {
  enum class Kind { kChessboard, kCharuco };
  Kind kind = Kind::kChessboard;
  int columns = 9, rows = 6;  ///< Inner corners of a chessboard; squares of a ChArUco board.
  double square_m = 0.025;    ///< Side of a square, metres.
  double marker_m = 0;        ///< Side of a ChArUco board's markers, metres.
  std::string dictionary = "4x4_50";
  int border_bits = 1;  ///< Width of the markers' black border, in cells.
};

/// Positions of the markers on a ChArUco board. OpenCV 4.6 changed them for boards with an even
/// number of rows.
enum class CharucoLayout {
  /// The top left square is black, as in OpenCV 4.6 and later, or for an odd number of rows.
  kBlackCorner,
  /// The top left square has marker 0, as in older OpenCV for an even number of rows.
  kMarkerCorner,
};

/// Parses "9x6" into columns and rows, each from 3 to 40. Returns an error message, or nothing.
std::string parse_board_size(const std::string& text, Board& board);

/// Returns an error message if the board cannot exist, or nothing. Requires a known dictionary.
std::string problem_of(const Board& board);

/// A board's corners in one picture: positions on the board (metres) and in the picture (pixels).
struct BoardView {
  std::string picture;  ///< The picture's name or number, for messages.
  std::vector<Eigen::Vector2d> on_board, pixels;
  /// Variance of the Laplacian over the board, relative to its contrast. Small when blurred.
  double sharpness = 0;
  CharucoLayout layout = CharucoLayout::kBlackCorner;
};

/// Finds the board in a scaled-down picture, then refines its corners in the full one. So a picture
/// of 12 megapixels takes about as long as a small one. Squares smaller than 1/20 of a large
/// picture may be missed. Returns nothing for fewer than six visible corners.
std::optional<BoardView> find_board(const Board& board, const ColorImage& picture, const std::string& name);

/// Looks for a board with another number of corners or another dictionary. Returns a description of
/// the found board with the flag for it, or an empty text. Slower than find_board().
std::string describe_other_board(const Board& board, const ColorImage& picture);

/// A view that is not used, and the reason.
struct DroppedView {
  std::string picture, why;
};

/// Returns the first of `others` that shows the same corners at the same pixels, within `kSameView`
/// of the picture's width. Returns null if there is none.
inline constexpr double kSameView = 0.02;
const BoardView* same_view(const BoardView& view, std::span<const BoardView> others, int width);

/// Leaves out blurred views (sharpness below a third of the median) and repeated ones
/// (same_view()). Keeps at most kMostViews: a fit's time grows with the cube of their number.
inline constexpr std::size_t kMostViews = 100;
std::vector<BoardView> select_views(std::vector<BoardView> views, int width,
                                    std::vector<DroppedView>& dropped);

}  // namespace copresence::calibrate
