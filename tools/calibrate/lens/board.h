#pragma once

// A calibration board in a picture: a chessboard, or a chessboard with ArUco markers in its white squares (ChArUco),
// which may be seen in part. Thread: pure functions.

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
  int columns = 9, rows = 6;  ///< inner corners of a chessboard; squares of a ChArUco board
  double square_m = 0.025;    ///< side of a square, metres
  double marker_m = 0;        ///< of a ChArUco board's markers
  std::string dictionary = "4x4_50";
  int border_bits = 1;  ///< width of the markers' black rim, in cells
};

/// Where a ChArUco board's markers lie. OpenCV 4.6 changed it for boards with an even number of rows.
enum class CharucoLayout {
  kBlackCorner,  ///< the top left square is black: OpenCV 4.6 and later; all boards with an odd number of rows
  kMarkerCorner,  ///< the top left square holds marker 0: OpenCV before 4.6, boards with an even number of rows
};

/// "9x6" into columns and rows, each from 3 to 40. Empty when understood, else what is wrong.
std::string parse_board_size(const std::string& text, Board& board);

/// Whether there can be such a board. Empty when so, else what is wrong. Requires a dictionary that there is.
std::string problem_of(const Board& board);

/// One picture's view of it: corners on the board (metres, z = 0) and where they appear (pixels).
struct BoardView {
  std::string picture;  ///< its name or number, for people
  std::vector<Eigen::Vector2d> on_board, pixels;
  /// Variance of the Laplacian over the board, relative to its contrast; less is more blurred.
  double sharpness = 0;
  CharucoLayout layout = CharucoLayout::kBlackCorner;  ///< of a ChArUco board: the one that fits the picture
};

/// Finds the board in a scaled-down picture first and then places its corners in the full one, so that a picture of
/// 12 megapixels takes about as long as a small one. What is smaller than 1/20 of a large picture may be missed.
/// Nothing where the picture shows no board, or fewer than six of its corners.
std::optional<BoardView> find_board(const Board& board, const ColorImage& picture, const std::string& name);

/// What the picture shows in place of `board`, and the flag to give for it: another number of corners, markers of another
/// dictionary. Empty where it shows nothing of the kind. Slower than find_board().
std::string board_seen_instead(const Board& board, const ColorImage& picture);

/// A view left out, and why.
struct DroppedView {
  std::string picture, why;
};

/// The first of `others` that shows the same corners in the same place of the picture, within `kSameView` of its width;
/// nullptr where none does.
inline constexpr double kSameView = 0.02;
const BoardView* same_view(const BoardView& view, std::span<const BoardView> others, int width);

/// Leaves out blurred views (sharpness below a third of the median) and those that are the same_view() as a kept one. Of
/// more than kMostViews, that many are kept: a fit's time grows with the cube of their number.
inline constexpr std::size_t kMostViews = 100;
std::vector<BoardView> worth_using(std::vector<BoardView> views, int width,
                                   std::vector<DroppedView>& dropped);

}  // namespace copresence::calibrate
