#include "tools/calibrate/lens/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

constexpr std::size_t kFewestCorners = 6;

cv::Mat gray_of(const ColorImage& picture) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat gray;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  return gray;
}

double sharpness_of(const cv::Mat& gray, const std::vector<cv::Point2f>& corners) {
  const cv::Rect around = cv::boundingRect(corners) & cv::Rect(0, 0, gray.cols, gray.rows);
  if (around.area() == 0) return 0;
  cv::Mat edges;
  cv::Laplacian(gray(around), edges, CV_64F);
  cv::Scalar mean, edge_deviation, deviation;
  cv::meanStdDev(edges, mean, edge_deviation);
  cv::meanStdDev(gray(around), mean, deviation);
  const double contrast = std::max(1.0, deviation[0]);
  return edge_deviation[0] * edge_deviation[0] / (contrast * contrast);
}

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

std::vector<cv::Point2f> find_chessboard(const Board& board, const cv::Mat& gray, std::vector<int>& ids) {
  std::vector<cv::Point2f> corners;
  const cv::Size size(board.columns, board.rows);
  if (!cv::findChessboardCorners(
          gray, size, corners,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK)) {
    return {};
  }
  const int half = std::clamp(static_cast<int>(0.4 * spacing(corners, board.columns)), 2, 11);
  cv::cornerSubPix(gray, corners, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 0.001));
  // A chessboard looks the same from above and below; it is taken to stand upright.
  if (corners.front().y > corners.back().y) std::reverse(corners.begin(), corners.end());
  for (int i = 0; i < board.columns * board.rows; ++i) ids.push_back(i);
  return corners;
}

std::vector<cv::Point2f> find_charuco(const Board& board, const cv::Mat& gray, std::vector<int>& ids) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(*dictionary_number(board.dictionary));
  const auto charuco =
      cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_m),
                                      static_cast<float>(board.marker_m), dictionary);
  std::vector<std::vector<cv::Point2f>> marker_corners;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(gray, dictionary, marker_corners, marker_ids);
  if (marker_ids.empty()) return {};
  std::vector<cv::Point2f> corners;
  cv::aruco::interpolateCornersCharuco(marker_corners, marker_ids, gray, charuco, corners, ids);
  return corners;
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
  const int held = cv::aruco::getPredefinedDictionary(*dictionary_number(board.dictionary))->bytesList.rows;
  if (needed <= held) return {};
  return fmt::format(
      "a ChArUco board of {}x{} squares has {} markers, but --dictionary {} holds {}: give the one that the "
      "board "
      "was printed with",
      board.columns, board.rows, needed, board.dictionary, held);
}

std::optional<BoardView> find_board(const Board& board, const ColorImage& picture, const std::string& name) {
  const cv::Mat gray = gray_of(picture);
  std::vector<int> ids;
  const bool is_chessboard = board.kind == Board::Kind::kChessboard;
  const auto corners = is_chessboard ? find_chessboard(board, gray, ids) : find_charuco(board, gray, ids);
  if (corners.size() < kFewestCorners) return std::nullopt;
  const int across = is_chessboard ? board.columns : board.columns - 1;
  BoardView view;
  view.picture = name;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    view.on_board.emplace_back(board.square_m * (ids[i] % across), board.square_m * (ids[i] / across));
    view.pixels.emplace_back(corners[i].x, corners[i].y);
  }
  view.sharpness = sharpness_of(gray, corners);
  return view;
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

std::vector<BoardView> worth_using(std::vector<BoardView> views, int width,
                                   std::vector<DroppedView>& dropped) {
  if (views.empty()) return views;
  std::vector<double> sharpness;
  for (const BoardView& view : views) sharpness.push_back(view.sharpness);
  const auto middle = sharpness.begin() + static_cast<std::ptrdiff_t>(sharpness.size() / 2);
  std::nth_element(sharpness.begin(), middle, sharpness.end());
  const double least = *middle / 3;
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
  return kept;
}

}  // namespace copresence::calibrate
