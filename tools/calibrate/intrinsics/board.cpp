#include "tools/calibrate/intrinsics/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/geometry/quantile.h"
#include "tools/calibrate/intrinsics/charuco_board.h"
#include "tools/calibrate/intrinsics/scaled_picture.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

constexpr std::size_t kFewestCorners = 6;

double sharpness_of(const cv::Mat& gray, const std::vector<cv::Point2f>& corners) {
  const cv::Rect around = cv::boundingRect(corners) & cv::Rect(0, 0, gray.cols, gray.rows);
  if (around.area() == 0) return 0;
  cv::Mat edges;
  cv::Laplacian(gray(around), edges, CV_16S);
  cv::Scalar mean, edge_deviation, deviation;
  cv::meanStdDev(edges, mean, edge_deviation);
  cv::meanStdDev(gray(around), mean, deviation);
  const double contrast = std::max(1.0, deviation[0]);
  return edge_deviation[0] * edge_deviation[0] / (contrast * contrast);
}

// Longer side of the picture for findChessboardCorners(), which then takes 0.01 to 0.2 s.
constexpr int kQuickSide = 640;

// Smallest distance between neighbouring corners of a full chessboard, pixels.
double spacing(const std::vector<cv::Point2f>& corners, int columns) {
  double least = 1e9;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    if ((i + 1) % static_cast<std::size_t>(columns) != 0) {
      least = std::min(least, cv::norm(corners[i + 1] - corners[i]));
    }
  }
  return least;
}

// A chessboard looks the same after half a turn. So the board must be upright and not mirrored.
void stand_upright(std::vector<cv::Point2f>& corners, int columns) {
  if (corners.front().y > corners.back().y) std::reverse(corners.begin(), corners.end());
  const cv::Point2f right = corners[static_cast<std::size_t>(columns) - 1] - corners[0],
                    down = corners[corners.size() - static_cast<std::size_t>(columns)] - corners[0];
  if (right.cross(down) > 0) return;
  for (auto row = corners.begin(); row != corners.end(); row += columns) std::reverse(row, row + columns);
}

std::vector<cv::Point2f> find_chessboard(const Board& board, const cv::Mat& gray, std::vector<int>& ids) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.columns, board.rows);
  const int longer = std::max(gray.cols, gray.rows);
  float pixel = 1;  // Number of pixels of the full picture per pixel of the searched picture.
  const auto found_in = [&](int side, bool quickly) {
    const ScaledPicture scaled(gray, side);
    // CALIB_CB_NORMALIZE_IMAGE would amplify the noise of a white rim, and a search would take 7 s.
    constexpr int kQuick = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK;
    const bool found = quickly ? cv::findChessboardCorners(scaled.gray(), size, corners, kQuick)
                               : cv::findChessboardCornersSB(scaled.gray(), size, corners, 0);
    if (!found) return false;
    scaled.to_full(corners);
    pixel = scaled.pixel();
    return true;
  };
  bool found = found_in(kQuickSide, true);
  for (std::size_t i = 0; i < kSearchSides.size() && !found; ++i) {
    if (i > 0 && longer <= kSearchSides[i - 1]) break;  // The full picture has been searched.
    found = found_in(kSearchSides[i], false);
  }
  if (!found) return {};
  const int widest = std::max(11, static_cast<int>(std::ceil(2 * pixel)));
  const int half = std::clamp(static_cast<int>(0.4 * spacing(corners, board.columns)), 2, widest);
  cv::cornerSubPix(gray, corners, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 0.001));
  stand_upright(corners, board.columns);
  for (int i = 0; i < board.columns * board.rows; ++i) ids.push_back(i);
  return corners;
}

// Finds chessboards with at least 3x3 inner corners.
std::string describe_other_chessboard(const Board& board, const ColorImage& picture) {
  const ScaledPicture scaled(gray_of(picture), kSearchSides[0]);
  std::vector<cv::Point2f> corners;
  cv::Mat squares;  // One entry per corner.
  if (!cv::findChessboardCornersSB(scaled.gray(), cv::Size(3, 3), corners, cv::CALIB_CB_LARGER, squares) ||
      (squares.cols == board.columns && squares.rows == board.rows) ||
      (squares.cols == board.rows && squares.rows == board.columns)) {
    return {};
  }
  const int columns = std::max(squares.cols, squares.rows), rows = std::min(squares.cols, squares.rows);
  const bool squares_given =
      columns + 1 == std::max(board.columns, board.rows) && rows + 1 == std::min(board.columns, board.rows);
  return fmt::format(
      "it shows {0}x{1} inner corners of a chessboard: {2}, or give --board-size {0}x{1} if that is all of "
      "it",
      columns, rows,
      squares_given ? "a board has one inner corner less than squares in each direction"
                    : "show the whole board");
}

}  // namespace

std::string parse_board_size(const std::string& text, Board& board) {
  int columns = 0, rows = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, columns);
  const bool has_cross = first.ptr != end && *first.ptr == 'x';
  const auto second = std::from_chars(has_cross ? first.ptr + 1 : end, end, rows);
  if (!has_cross || second.ptr != end || columns < 3 || columns > 40 || rows < 3 || rows > 40) {
    return fmt::format("\"{}\" is not COLUMNSxROWS, each from 3 to 40", text);
  }
  board.columns = columns;
  board.rows = rows;
  return {};
}

std::string problem_of(const Board& board) {
  if (board.kind == Board::Kind::kChessboard) return {};
  if (board.marker_m >= board.square_m) return "a ChArUco board's markers must be smaller than its squares";
  const int needed = board.columns * board.rows / 2;
  const int held = markers_in(board.dictionary);
  if (needed <= held) return {};
  return fmt::format(
      "a ChArUco board of {}x{} squares has {} markers, but --dictionary {} holds {}: give the one that the "
      "board "
      "was printed with",
      board.columns, board.rows, needed, board.dictionary, held);
}

std::optional<BoardView> find_board(const Board& board, const ColorImage& picture, const std::string& name) {
  const cv::Mat gray = gray_of(picture);
  const bool is_chessboard = board.kind == Board::Kind::kChessboard;
  BoardView view;
  std::vector<cv::Point2f> corners;
  std::vector<int> ids;
  if (is_chessboard) {
    corners = find_chessboard(board, gray, ids);
  } else {
    CharucoCorners found = find_charuco(board, gray);
    corners = std::move(found.pixels);
    ids = std::move(found.numbers);
    view.layout = found.layout;
  }
  if (corners.size() < kFewestCorners) return std::nullopt;
  const int across = is_chessboard ? board.columns : board.columns - 1;
  view.picture = name;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    view.on_board.emplace_back(board.square_m * (ids[i] % across), board.square_m * (ids[i] / across));
    view.pixels.emplace_back(corners[i].x, corners[i].y);
  }
  view.sharpness = sharpness_of(gray, corners);
  return view;
}

std::string describe_other_board(const Board& board, const ColorImage& picture) {
  return board.kind == Board::Kind::kChessboard ? describe_other_chessboard(board, picture)
                                                : describe_other_charuco(board, picture);
}

const BoardView* same_view(const BoardView& view, std::span<const BoardView> others, int width) {
  const auto same = std::find_if(others.begin(), others.end(), [&](const BoardView& other) {
    double sum = 0;
    std::size_t common = 0;
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      const auto there = std::find(other.on_board.begin(), other.on_board.end(), view.on_board[i]);
      if (there == other.on_board.end()) continue;
      sum += (other.pixels[static_cast<std::size_t>(there - other.on_board.begin())] - view.pixels[i]).norm();
      ++common;
    }
    return common > 0 && sum / static_cast<double>(common) < kSameView * width;
  });
  return same == others.end() ? nullptr : &*same;
}

std::vector<BoardView> select_views(std::vector<BoardView> views, int width,
                                    std::vector<DroppedView>& dropped) {
  if (views.empty()) return views;
  std::vector<double> sharpness;
  for (const BoardView& view : views) sharpness.push_back(view.sharpness);
  const double least = median(std::move(sharpness)) / 3;
  std::vector<BoardView> kept;
  for (BoardView& view : views) {
    if (view.sharpness < least) {
      dropped.push_back({view.picture, "blurred"});
    } else if (const BoardView* same = same_view(view, kept, width)) {
      dropped.push_back({view.picture, "the same view as " + same->picture});
    } else {
      kept.push_back(std::move(view));
    }
  }
  if (kept.size() <= kMostViews) return kept;
  std::vector<BoardView> some;  // Evenly spread.
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const bool is_chosen = i * kMostViews / kept.size() != (i + 1) * kMostViews / kept.size();
    if (is_chosen) {
      some.push_back(std::move(kept[i]));
    } else {
      dropped.push_back({kept[i].picture, "there are enough views"});
    }
  }
  return some;
}

}  // namespace copresence::calibrate
