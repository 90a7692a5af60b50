#include "tools/calibrate/intrinsics/charuco_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tools/calibrate/intrinsics/scaled_picture.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

// Corners of the markers on the board, by marker number; metres.
using MarkerCorners = std::vector<std::array<cv::Point2f, 4>>;

MarkerCorners markers_of(const Board& board, CharucoLayout layout) {
  const auto square = static_cast<float>(board.square_m), marker = static_cast<float>(board.marker_m);
  MarkerCorners markers;
  for (int y = 0; y < board.rows; ++y) {
    for (int x = 0; x < board.columns; ++x) {
      if (((x + y) % 2 == 0) == (layout == CharucoLayout::kBlackCorner)) continue;
      const float left = (static_cast<float>(x) + 0.5f) * square - marker / 2,
                  top = (static_cast<float>(y) + 0.5f) * square - marker / 2;
      markers.push_back(
          {{{left, top}, {left + marker, top}, {left + marker, top + marker}, {left, top + marker}}});
    }
  }
  return markers;
}

using SeenMarkers = std::map<std::size_t, std::vector<cv::Point2f>>;  // Corners in pixels, by marker number.

double sides_of(const std::vector<cv::Point2f>& corners) {
  double sides = 0;
  for (std::size_t i = 0; i < 4; ++i) sides += cv::norm(corners[(i + 1) % 4] - corners[i]);
  return sides;
}

// Searches a scaled-down picture. If that picture shows no markers or only small ones, searches a
// larger picture.
SeenMarkers find_markers(const Board& board, const cv::Mat& gray) {
  constexpr double kSmall = 20;  // Side in pixels. The search misses many smaller markers.
  const auto dictionary = make_dictionary(board.dictionary);
  const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
  parameters->markerBorderBits = board.border_bits;
  SeenMarkers best;
  for (const int side : kSearchSides) {
    const ScaledPicture scaled(gray, side);
    std::vector<std::vector<cv::Point2f>> all;
    std::vector<int> numbers;
    cv::aruco::detectMarkers(scaled.gray(), dictionary, all, numbers, parameters);
    SeenMarkers seen;
    double sides = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      sides += cv::norm(all[i][1] - all[i][0]);
      scaled.to_full(all[i]);
      seen[static_cast<std::size_t>(numbers[i])] = all[i];
    }
    const bool small = sides <= kSmall * static_cast<double>(numbers.size());
    if (seen.size() >= best.size()) best = std::move(seen);
    if (!small || std::max(gray.cols, gray.rows) <= side) break;
  }
  return best;
}

// Mean distance of the markers' corners from the board's best homography, relative to the markers'
// size. A wide lens's distortion causes 0.1, a wrong layout 1 or more. Empty for too few markers.
std::optional<double> misfit(const MarkerCorners& markers, const SeenMarkers& seen) {
  std::vector<cv::Point2f> on_board, pixels;
  double sides = 0;
  for (const auto& [number, corners] : seen) {
    if (number >= markers.size()) continue;
    on_board.insert(on_board.end(), markers[number].begin(), markers[number].end());
    pixels.insert(pixels.end(), corners.begin(), corners.end());
    sides += sides_of(corners);
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

// Predicts each inner corner from the homographies of the two markers beside it. Leaves out corners
// with fewer markers.
void predict_corners(const Board& board, const MarkerCorners& markers, const SeenMarkers& seen,
                     const cv::Size& size, CharucoCorners& out) {
  const auto square = static_cast<float>(board.square_m);
  std::map<std::size_t, cv::Mat> homographies;
  for (const auto& [number, corners] : seen) {
    if (number >= markers.size()) continue;
    homographies[number] = cv::getPerspectiveTransform(
        std::vector<cv::Point2f>(markers[number].begin(), markers[number].end()), corners);
  }
  for (int y = 1; y < board.rows; ++y) {
    for (int x = 1; x < board.columns; ++x) {
      const cv::Point2f corner(static_cast<float>(x) * square, static_cast<float>(y) * square);
      cv::Point2f sum(0, 0);
      int count = 0;
      for (const auto& [number, homography] : homographies) {
        const cv::Point2f middle = 0.5f * (markers[number][0] + markers[number][2]);
        // The centres of touching squares are 0.71 squares from the corner.
        if (cv::norm(middle - corner) > 0.8f * square) continue;
        std::vector<cv::Point2f> pixel;
        cv::perspectiveTransform(std::vector<cv::Point2f>{corner}, pixel, homography);
        sum += pixel[0];
        ++count;
      }
      if (count < 2) continue;
      const cv::Point2f pixel = 0.5f * sum;
      if (!cv::Rect2f(0, 0, static_cast<float>(size.width - 1), static_cast<float>(size.height - 1))
               .contains(pixel)) {
        continue;
      }
      out.pixels.push_back(pixel);
      out.numbers.push_back((y - 1) * (board.columns - 1) + x - 1);
    }
  }
}

}  // namespace

CharucoCorners find_charuco(const Board& board, const cv::Mat& gray) {
  const SeenMarkers seen = find_markers(board, gray);
  CharucoCorners found;
  MarkerCorners best;
  double least = kMostMisfit;
  for (const CharucoLayout layout : layouts_of(board)) {
    MarkerCorners markers = markers_of(board, layout);
    const auto off = misfit(markers, seen);
    if (!off || *off >= least) continue;
    least = *off;
    best = std::move(markers);
    found.layout = layout;
  }
  if (best.empty()) return found;
  predict_corners(board, best, seen, gray.size(), found);
  if (found.pixels.empty()) return found;
  double sides = 0;
  for (const auto& [number, corners] : seen) sides += sides_of(corners);
  const double side = sides / static_cast<double>(4 * seen.size());
  // The search window must not reach the markers beside the corner.
  const double rim = side * 0.5 * (board.square_m - board.marker_m) / board.marker_m;
  const int half = std::clamp(static_cast<int>(rim), 2, 11);
  cv::cornerSubPix(gray, found.pixels, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 0.001));
  return found;
}

std::string describe_other_charuco(const Board& board, const ColorImage& picture) {
  const SeenMarkers seen = find_markers(board, gray_of(picture));
  if (seen.empty()) {
    const auto other = find_dictionary(picture);
    return other ? fmt::format("it shows {}", other->in_words()) : "";
  }
  const auto highest = static_cast<int>(seen.rbegin()->first);
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
    if (columns < 2 || rows < 2 || columns * rows / 2 <= highest || !problem_of(other).empty()) continue;
    for (const CharucoLayout layout : layouts_of(other)) {
      const auto off = misfit(markers_of(other, layout), seen);
      if (!off || *off >= least) continue;
      least = *off;
      best = other;
    }
  }
  if (least == kMostMisfit) return {};
  return fmt::format("its markers lie as on a ChArUco board of {0}x{1} squares: give --board-size {0}x{1}",
                     best.columns, best.rows);
}

}  // namespace copresence::calibrate
