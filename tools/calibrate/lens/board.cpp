#include "tools/calibrate/lens/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
  cv::Laplacian(gray(around), edges, CV_16S);
  cv::Scalar mean, edge_deviation, deviation;
  cv::meanStdDev(edges, mean, edge_deviation);
  cv::meanStdDev(gray(around), mean, deviation);
  const double contrast = std::max(1.0, deviation[0]);
  return edge_deviation[0] * edge_deviation[0] / (contrast * contrast);
}

// A picture scaled down so that its longer side has at most `side` pixels, and the way back.
class Scaled {
 public:
  Scaled(const cv::Mat& gray, int side) : gray_(gray) {
    const double scale = static_cast<double>(side) / std::max(gray.cols, gray.rows);
    if (scale < 1) {
      const cv::Size size(std::max(1, cvRound(gray.cols * scale)), std::max(1, cvRound(gray.rows * scale)));
      cv::resize(gray, gray_, size, 0, 0, cv::INTER_AREA);
    }
    x_ = static_cast<float>(gray.cols) / static_cast<float>(gray_.cols);
    y_ = static_cast<float>(gray.rows) / static_cast<float>(gray_.rows);
  }

  const cv::Mat& gray() const { return gray_; }
  float pixel() const { return std::max(x_, y_); }  ///< size of one of its pixels in the full picture
  void to_full(std::vector<cv::Point2f>& points) const {
    for (cv::Point2f& p : points) p = {(p.x + 0.5f) * x_ - 0.5f, (p.y + 0.5f) * y_ - 0.5f};
  }

 private:
  cv::Mat gray_;
  float x_ = 1, y_ = 1;
};

// Longer sides, pixels. Each bounds the time that a search may take, whatever the picture shows.
constexpr int kQuickSide = 640;                   // findChessboardCorners(): 0.01 to 0.2 s
constexpr std::array kThoroughSides{1280, 2560};  // findChessboardCornersSB(): 0.3 s and 1.2 s

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

// A chessboard looks the same from above and below; it is taken to stand upright, and never to be seen in a mirror.
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
  float pixel = 1;  // of the picture that the board was found in
  const auto found_in = [&](int side, bool quickly) {
    const Scaled scaled(gray, side);
    // Not CALIB_CB_NORMALIZE_IMAGE: it makes noise of a white rim so strong that a search takes 7 s.
    constexpr int kQuick = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK;
    const bool found = quickly ? cv::findChessboardCorners(scaled.gray(), size, corners, kQuick)
                               : cv::findChessboardCornersSB(scaled.gray(), size, corners, 0);
    if (!found) return false;
    scaled.to_full(corners);
    pixel = scaled.pixel();
    return true;
  };
  bool found = found_in(kQuickSide, true);
  for (std::size_t i = 0; i < kThoroughSides.size() && !found; ++i) {
    if (i > 0 && longer <= kThoroughSides[i - 1]) break;  // all of it has been looked at
    found = found_in(kThoroughSides[i], false);
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

using Dictionary = cv::Ptr<cv::aruco::Dictionary>;

// The board as OpenCV's interpolation wants it, whichever layout its own version makes.
cv::Ptr<cv::aruco::CharucoBoard> charuco_of(const Board& board, CharucoLayout layout,
                                            const Dictionary& dictionary) {
  const auto square = static_cast<float>(board.square_m), marker = static_cast<float>(board.marker_m);
  auto charuco = cv::aruco::CharucoBoard::create(board.columns, board.rows, square, marker, dictionary);
  charuco->objPoints.clear();
  charuco->ids.clear();
  std::vector<cv::Point2f> middles;
  for (int y = 0; y < board.rows; ++y) {
    for (int x = 0; x < board.columns; ++x) {
      if (((x + y) % 2 == 0) == (layout == CharucoLayout::kBlackCorner)) continue;
      const cv::Point2f middle((static_cast<float>(x) + 0.5f) * square,
                               (static_cast<float>(y) + 0.5f) * square);
      const float left = middle.x - marker / 2, top = middle.y - marker / 2;
      charuco->ids.push_back(static_cast<int>(middles.size()));
      charuco->objPoints.push_back({{left, top, 0},
                                    {left + marker, top, 0},
                                    {left + marker, top + marker, 0},
                                    {left, top + marker, 0}});
      middles.push_back(middle);
    }
  }
  charuco->chessboardCorners.clear();
  charuco->nearestMarkerIdx.clear();
  charuco->nearestMarkerCorners.clear();
  for (int y = 1; y < board.rows; ++y) {
    for (int x = 1; x < board.columns; ++x) {
      const cv::Point2f corner(static_cast<float>(x) * square, static_cast<float>(y) * square);
      charuco->chessboardCorners.emplace_back(corner.x, corner.y, 0);
      std::vector<int> markers, marker_corners;
      for (std::size_t m = 0; m < middles.size(); ++m) {
        const cv::Point2f away = middles[m] - corner;
        if (cv::norm(away) > 0.8 * square) continue;  // the two squares that touch the corner: at 0.71
        markers.push_back(static_cast<int>(m));
        // Clockwise from the top left; the marker's corner that points to the board's.
        marker_corners.push_back(away.y > 0 ? (away.x > 0 ? 0 : 1) : (away.x > 0 ? 3 : 2));
      }
      charuco->nearestMarkerIdx.push_back(std::move(markers));
      charuco->nearestMarkerCorners.push_back(std::move(marker_corners));
    }
  }
  return charuco;
}

struct SeenMarkers {
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
};

// Looks in a scaled-down picture, and in a larger one where there are none or only small ones. Corners in the full
// picture.
SeenMarkers find_markers(const Board& board, const cv::Mat& gray, const Dictionary& dictionary) {
  constexpr double kSmall = 20;  // pixels of a marker's side, below which many are missed
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = board.border_bits;
  SeenMarkers best;
  for (const int side : kThoroughSides) {
    const Scaled scaled(gray, side);
    SeenMarkers seen;
    cv::aruco::detectMarkers(scaled.gray(), dictionary, seen.corners, seen.ids, parameters);
    double sides = 0;
    for (auto& corners : seen.corners) {
      sides += cv::norm(corners[1] - corners[0]);
      scaled.to_full(corners);
    }
    const bool small = sides <= kSmall * static_cast<double>(seen.ids.size());
    if (seen.ids.size() >= best.ids.size()) best = std::move(seen);
    if (!small || std::max(gray.cols, gray.rows) <= side) break;
  }
  return best;
}

// How far the markers lie from one plane's picture of the board, as a share of their size; distortion of a wide lens
// makes a tenth of it, another layout one or more. Nothing where too few are seen to tell.
std::optional<double> misfit(const cv::aruco::CharucoBoard& charuco, const SeenMarkers& seen) {
  std::vector<cv::Point2f> on_board, pixels;
  double sides = 0;
  for (std::size_t i = 0; i < seen.ids.size(); ++i) {
    const auto id = static_cast<std::size_t>(seen.ids[i]);
    if (id >= charuco.objPoints.size()) continue;
    for (std::size_t c = 0; c < 4; ++c) {
      on_board.emplace_back(charuco.objPoints[id][c].x, charuco.objPoints[id][c].y);
      pixels.push_back(seen.corners[i][c]);
      sides += cv::norm(seen.corners[i][c] - seen.corners[i][(c + 1) % 4]);
    }
  }
  if (pixels.size() < 8) return std::nullopt;
  const cv::Mat homography = cv::findHomography(on_board, pixels);
  if (homography.empty()) return std::nullopt;
  std::vector<cv::Point2f> expected;
  cv::perspectiveTransform(on_board, expected, homography);
  double off = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) off += cv::norm(expected[i] - pixels[i]);
  return off / sides;
}

constexpr double kMostMisfit = 0.3;

std::vector<CharucoLayout> layouts_of(const Board& board) {
  if (board.rows % 2 != 0) return {CharucoLayout::kBlackCorner};
  return {CharucoLayout::kBlackCorner, CharucoLayout::kMarkerCorner};
}

std::vector<cv::Point2f> find_charuco(const Board& board, const cv::Mat& gray, std::vector<int>& ids,
                                      CharucoLayout& layout) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(*dictionary_number(board.dictionary));
  const SeenMarkers seen = find_markers(board, gray, dictionary);
  if (seen.ids.empty()) return {};
  cv::Ptr<cv::aruco::CharucoBoard> best;
  double least = kMostMisfit;
  for (const CharucoLayout tried : layouts_of(board)) {
    auto charuco = charuco_of(board, tried, dictionary);
    const auto off = misfit(*charuco, seen);
    if (!off || *off >= least) continue;
    least = *off;
    best = std::move(charuco);
    layout = tried;
  }
  if (!best) return {};
  std::vector<cv::Point2f> corners;
  cv::aruco::interpolateCornersCharuco(seen.corners, seen.ids, gray, best, corners, ids);
  if (corners.empty()) return {};
  // OpenCV places these corners as if a pixel's centre lay at (0.5, 0.5), so half a pixel off. The window must not reach
  // the markers beside the corner.
  double sides = 0;
  for (const auto& marker : seen.corners)
    sides += cv::norm(marker[1] - marker[0]) + cv::norm(marker[2] - marker[1]);
  const double side = sides / static_cast<double>(2 * seen.corners.size());
  const double rim = side * 0.5 * (board.square_m - board.marker_m) / board.marker_m;
  const int half = std::clamp(static_cast<int>(rim), 2, 11);
  cv::cornerSubPix(gray, corners, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 0.001));
  return corners;
}

// Of a chessboard with at least 3x3 inner corners.
std::string chessboard_seen_instead(const Board& board, const ColorImage& picture) {
  const Scaled scaled(gray_of(picture), kThoroughSides[0]);
  std::vector<cv::Point2f> corners;
  cv::Mat squares;  // one number per corner found
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

std::string charuco_seen_instead(const Board& board, const ColorImage& picture) {
  const cv::Mat gray = gray_of(picture);
  const auto dictionary = cv::aruco::getPredefinedDictionary(*dictionary_number(board.dictionary));
  const SeenMarkers seen = find_markers(board, gray, dictionary);
  if (seen.ids.empty()) {
    const auto other = seen_dictionary(picture);
    return other ? fmt::format("it shows {}", other->in_words()) : "";
  }
  const int most = *std::max_element(seen.ids.begin(), seen.ids.end());
  Board best = board;
  double least = kMostMisfit;
  for (const auto& [columns, rows] :
       std::initializer_list<std::pair<int, int>>{{board.rows, board.columns},
                                                  {board.columns + 1, board.rows + 1},
                                                  {board.rows + 1, board.columns + 1},
                                                  {board.columns + 1, board.rows},
                                                  {board.columns, board.rows + 1},
                                                  {board.columns - 1, board.rows - 1},
                                                  {board.rows - 1, board.columns - 1},
                                                  {board.columns - 1, board.rows},
                                                  {board.columns, board.rows - 1}}) {
    Board other = board;
    other.columns = columns;
    other.rows = rows;
    if (columns < 2 || rows < 2 || columns * rows / 2 <= most || !problem_of(other).empty()) continue;
    for (const CharucoLayout layout : layouts_of(other)) {
      const auto off = misfit(*charuco_of(other, layout, dictionary), seen);
      if (!off || *off >= least) continue;
      least = *off;
      best = other;
    }
  }
  if (least == kMostMisfit) return {};
  return fmt::format("its markers lie as on a ChArUco board of {0}x{1} squares: give --board-size {0}x{1}",
                     best.columns, best.rows);
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
  BoardView view;
  const auto corners =
      is_chessboard ? find_chessboard(board, gray, ids) : find_charuco(board, gray, ids, view.layout);
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

std::string board_seen_instead(const Board& board, const ColorImage& picture) {
  return board.kind == Board::Kind::kChessboard ? chessboard_seen_instead(board, picture)
                                                : charuco_seen_instead(board, picture);
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
  if (kept.size() <= kMostViews) return kept;
  std::vector<BoardView> some;  // evenly spread
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
