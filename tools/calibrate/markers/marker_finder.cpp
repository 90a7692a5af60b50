#include "tools/calibrate/markers/marker_finder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "tools/calibrate/geometry/quantile.h"
#include "tools/calibrate/markers/dictionary.h"

namespace copresence::calibrate {
namespace {

// Interpolates brightness bilinearly; pixel centres are at whole coordinates.
double brightness(const Image<std::uint8_t>& picture, const Eigen::Vector2d& at) {
  const int x = std::clamp(static_cast<int>(std::floor(at.x())), 0, picture.width() - 2);
  const int y = std::clamp(static_cast<int>(std::floor(at.y())), 0, picture.height() - 2);
  const double u = at.x() - x, v = at.y() - y;
  const double top = picture(x, y) * (1 - u) + picture(x + 1, y) * u;
  const double bottom = picture(x, y + 1) * (1 - u) + picture(x + 1, y + 1) * u;
  return top * (1 - v) + bottom * v;
}

// Distance from `at` along the unit vector `outward` to the edge between dark and light. The edge
// is the centre of the steepest rise.
std::optional<double> edge_along(const Image<std::uint8_t>& picture, const Eigen::Vector2d& at,
                                 const Eigen::Vector2d& outward, double reach) {
  constexpr double kStep = 0.25, kHalfRise = 0.75;
  double best = 12, where = 0, weight = 0, sum = 0;  // Rises of brightness below 12 of 255 are noise.
  for (double s = -reach; s <= reach; s += kStep) {
    const double rise = brightness(picture, at + (s + kHalfRise) * outward) -
                        brightness(picture, at + (s - kHalfRise) * outward);
    if (rise > best) {
      best = rise;
      where = s;
    }
  }
  if (best <= 12) return std::nullopt;
  for (double s = where - 1.5; s <= where + 1.5; s += kStep) {
    const double rise = std::max(0.0, brightness(picture, at + (s + kHalfRise) * outward) -
                                          brightness(picture, at + (s - kHalfRise) * outward));
    sum += rise * s;
    weight += rise;
  }
  return sum / weight;
}

struct Line {
  Eigen::Vector2d point, direction;
};

// Fits a line to the points, then again without the farthest fifth.
std::optional<Line> fit_line(std::vector<Eigen::Vector2d> points) {
  Line line;
  for (int round = 0; round < 2; ++round) {
    if (points.size() < 4) return std::nullopt;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& p : points) scatter += (p - mean) * (p - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
    line = {mean, axes.eigenvectors().col(1)};
    const Eigen::Vector2d across = axes.eigenvectors().col(0);
    std::sort(points.begin(), points.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return std::abs(across.dot(a - mean)) < std::abs(across.dot(b - mean));
    });
    points.resize(points.size() - points.size() / 5);
  }
  return line;
}

}  // namespace

bool refine_outline(const Image<std::uint8_t>& picture, std::array<Eigen::Vector2d, 4>& corners) {
  for (int round = 0; round < 3; ++round) {
    std::array<Line, 4> lines;
    const Eigen::Vector2d middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
    for (std::size_t side = 0; side < 4; ++side) {
      const Eigen::Vector2d a = corners[side], along = corners[(side + 1) % 4] - a;
      const double length = along.norm();
      if (length < 6) return false;
      Eigen::Vector2d outward(along.y() / length, -along.x() / length);
      if (outward.dot(a - middle) < 0) outward = -outward;
      // The search is wide enough for a bad first guess, but stays within the black border cell and
      // the white rim.
      const double reach = std::min(round == 0 ? 3.5 : 2.0, 0.9 * std::abs(outward.dot(a - middle)) / 3);
      std::vector<Eigen::Vector2d> points;
      const int samples = std::clamp(static_cast<int>(length), 8, 60);
      for (int i = 0; i < samples; ++i) {
        const Eigen::Vector2d at = a + along * (0.1 + 0.8 * (i + 0.5) / samples);
        if (const auto off = edge_along(picture, at, outward, reach)) points.push_back(at + *off * outward);
      }
      const auto line = fit_line(std::move(points));
      if (!line) return false;
      lines[side] = *line;
    }
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Line &p = lines[(corner + 3) % 4], &q = lines[corner];
      Eigen::Matrix2d both;
      both << p.direction, -q.direction;
      if (std::abs(both.determinant()) < 0.05) return false;
      const Eigen::Vector2d crossing = p.point + p.direction * (both.inverse() * (q.point - p.point)).x();
      if ((crossing - corners[corner]).norm() > 10) return false;
      corners[corner] = crossing;
    }
  }
  return true;
}

namespace {

template <class Corners>
Corners median_corners(const std::vector<Corners>& observations) {
  Corners out;
  for (std::size_t corner = 0; corner < out.size(); ++corner) {
    std::vector<double> x, y;
    for (const Corners& observation : observations) {
      x.push_back(observation[corner].x());
      y.push_back(observation[corner].y());
    }
    out[corner] = {median(std::move(x)), median(std::move(y))};
  }
  return out;
}

// The diagonals are straight only without distortion.
Eigen::Vector2d crossing_of_diagonals(const CameraModel& model,
                                      const std::array<Eigen::Vector2d, 4>& corners) {
  std::array<Eigen::Vector3d, 4> rays;
  for (std::size_t i = 0; i < 4; ++i) rays[i] = unproject(model, corners[i], 1);
  const Eigen::Vector3d middle = rays[0].cross(rays[2]).cross(rays[1].cross(rays[3]));
  return project(model, middle / middle.z());
}

}  // namespace

Result<MarkerFinder> MarkerFinder::open(const std::string& dictionary, int border_bits) {
  const auto names = marker_dictionaries();
  if (std::find(names.begin(), names.end(), dictionary) == names.end()) {
    return fail(ErrorCode::kInvalid, fmt::format("there is no marker dictionary \"{}\"; there are {}",
                                                 dictionary, fmt::join(names, ", ")));
  }
  return MarkerFinder(dictionary, border_bits);
}

void MarkerFinder::add(const ColorImage& picture) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat gray;
  cv::cvtColor(rgb, gray, cv::COLOR_RGB2GRAY);
  Image<std::uint8_t> copy(picture.width(), picture.height());
  gray.copyTo(cv::Mat(copy.height(), copy.width(), CV_8UC1, copy.data()));
  add_gray(copy);
}

void MarkerFinder::add_gray(const Image<std::uint8_t>& picture) {
  const cv::Mat gray(picture.height(), picture.width(), CV_8UC1, const_cast<std::uint8_t*>(picture.data()));
  const auto dictionary = make_dictionary(dictionary_);
  const auto parameters = cv::makePtr<cv::aruco::DetectorParameters>();
  parameters->markerBorderBits = border_bits_;
  // A perimeter of 13 pixels in a picture of width 640. Smaller markers have too little depth.
  parameters->minMarkerPerimeterRate = 0.02;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(gray, dictionary, corners, ids, parameters);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Corners observation;
    for (std::size_t corner = 0; corner < 4; ++corner)
      observation[corner] = {corners[i][corner].x, corners[i][corner].y};
    if (!refine_outline(picture, observation)) continue;
    seen_[ids[i]].push_back(observation);
  }
  ++pictures_;
}

bool MarkerFinder::is_still(const std::vector<Corners>& observations) const {
  const Corners middle = median_corners(observations);
  const auto away = std::count_if(observations.begin(), observations.end(), [&](const Corners& observation) {
    double most = 0;
    for (std::size_t i = 0; i < 4; ++i) most = std::max(most, (observation[i] - middle[i]).norm());
    return most > kStill;
  });
  // A few wrong corners do not count as motion.
  return 5 * away <= static_cast<std::ptrdiff_t>(observations.size());
}

std::vector<FoundMarker> MarkerFinder::found(const CameraModel& model) const {
  std::vector<FoundMarker> markers;
  for (const auto& [id, observations] : seen_) {
    if (3 * observations.size() < static_cast<std::size_t>(pictures_) || !is_still(observations)) continue;
    const Corners corners = median_corners(observations);
    FoundMarker marker;
    marker.name = std::to_string(id);
    marker.corners.assign(corners.begin(), corners.end());
    marker.middle = crossing_of_diagonals(model, corners);
    markers.push_back(std::move(marker));
  }
  return markers;
}

std::vector<std::string> MarkerFinder::moved() const {
  std::vector<std::string> names;
  for (const auto& [id, observations] : seen_) {
    if (!is_still(observations)) names.push_back(std::to_string(id));
  }
  return names;
}

}  // namespace copresence::calibrate
