#include "tools/calibrate/markers/marker_finder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/markers/dictionary.h"
#include "tools/calibrate/markers/outline.h"

namespace copresence::calibrate {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <class Corners>
Corners median_corners(const std::vector<Corners>& sightings) {
  Corners out;
  for (std::size_t corner = 0; corner < out.size(); ++corner) {
    std::vector<double> x, y;
    for (const Corners& sighting : sightings) {
      x.push_back(sighting[corner].x());
      y.push_back(sighting[corner].y());
    }
    out[corner] = {median(std::move(x)), median(std::move(y))};
  }
  return out;
}

// Straight lines stay straight only without the lens's distortion.
Eigen::Vector2d crossing_of_diagonals(const CameraModel& model,
                                      const std::array<Eigen::Vector2d, 4>& corners) {
  std::array<Eigen::Vector3d, 4> rays;
  for (std::size_t i = 0; i < 4; ++i) rays[i] = unproject(model, corners[i], 1);
  const Eigen::Vector3d middle = rays[0].cross(rays[2]).cross(rays[1].cross(rays[3]));
  return project(model, middle / middle.z());
}

}  // namespace

Result<MarkerFinder> MarkerFinder::open(const std::string& dictionary, int border_bits) {
  const auto number = dictionary_number(dictionary);
  if (!number) {
    return fail(ErrorCode::kInvalid, fmt::format("there is no marker dictionary \"{}\"; there are {}",
                                                 dictionary, fmt::join(marker_dictionaries(), ", ")));
  }
  return MarkerFinder(*number, border_bits);
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
  const auto dictionary = cv::aruco::getPredefinedDictionary(dictionary_);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border_bits_;
  parameters->minMarkerPerimeterRate =
      0.02;  // 13 pixels of outline in 640: smaller ones have no depth to speak of
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(gray, dictionary, corners, ids, parameters);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Corners sighting;
    for (std::size_t corner = 0; corner < 4; ++corner)
      sighting[corner] = {corners[i][corner].x, corners[i][corner].y};
    if (!refine_outline(picture, sighting)) continue;
    seen_[ids[i]].push_back(sighting);
  }
  ++pictures_;
}

bool MarkerFinder::is_still(const std::vector<Corners>& sightings) const {
  const Corners middle = median_corners(sightings);
  const auto away = std::count_if(sightings.begin(), sightings.end(), [&](const Corners& sighting) {
    double most = 0;
    for (std::size_t i = 0; i < 4; ++i) most = std::max(most, (sighting[i] - middle[i]).norm());
    return most > kStill;
  });
  return 5 * away <=
         static_cast<std::ptrdiff_t>(sightings.size());  // a wrong corner now and then is no motion
}

std::vector<FoundMarker> MarkerFinder::found(const CameraModel& model) const {
  std::vector<FoundMarker> markers;
  for (const auto& [id, sightings] : seen_) {
    if (3 * sightings.size() < static_cast<std::size_t>(pictures_) || !is_still(sightings)) continue;
    const Corners corners = median_corners(sightings);
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
  for (const auto& [id, sightings] : seen_) {
    if (!is_still(sightings)) names.push_back(std::to_string(id));
  }
  return names;
}

}  // namespace copresence::calibrate
