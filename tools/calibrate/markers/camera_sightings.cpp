#include "tools/calibrate/markers/camera_sightings.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

namespace copresence::calibrate {
namespace {

using calibration::DepthAverage;

// The nearer half of what has depth around a click is dropped with the median: a hand's edge does no harm.
std::optional<double> depth_around(const DepthAverage& depth, const Eigen::Vector2d& pixel) {
  constexpr int kReach = 6;
  std::vector<double> near;
  const int x0 = static_cast<int>(std::lround(pixel.x())), y0 = static_cast<int>(std::lround(pixel.y()));
  for (int y = std::max(0, y0 - kReach); y <= std::min(depth.height() - 1, y0 + kReach); ++y) {
    for (int x = std::max(0, x0 - kReach); x <= std::min(depth.width() - 1, x0 + kReach); ++x) {
      const double inverse = depth.inverse_depth(x, y);
      if (inverse > 0) near.push_back(inverse);
    }
  }
  if (near.empty()) return std::nullopt;
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
  std::nth_element(near.begin(), middle, near.end());
  return 1 / *middle;
}

// Where the marker's surface is looked for. The white border around a detected one belongs to it, and helps where
// its dark cells return nothing.
std::optional<std::vector<Eigen::Vector2d>> outline_of(const FoundMarker& marker, const CameraModel& model,
                                                       const DepthAverage& depth) {
  std::vector<Eigen::Vector2d> outline;
  if (!marker.corners.empty()) {
    constexpr double kGrown = 1.1;
    for (const Eigen::Vector2d& corner : marker.corners) {
      outline.push_back(marker.middle + kGrown * (corner - marker.middle));
    }
    return outline;
  }
  const auto z = depth_around(depth, marker.middle);
  if (!z) return std::nullopt;
  constexpr int kSides = 16;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    outline.push_back(marker.middle +
                      kClickRadius / *z *
                          Eigen::Vector2d(model.fx * std::cos(angle), model.fy * std::sin(angle)));
  }
  return outline;
}

}  // namespace

CameraSightings sightings_of(std::size_t camera, const std::string& camera_name, const CameraModel& model,
                             std::span<const FoundMarker> markers, const DepthAverage& depth,
                             const std::vector<std::string>& marker_names) {
  CameraSightings out;
  for (const FoundMarker& marker : markers) {
    const auto named = std::find(marker_names.begin(), marker_names.end(), marker.name);
    assert(named != marker_names.end());
    const auto outline = outline_of(marker, model, depth);
    if (!outline) {
      out.unused.push_back({camera_name, marker.name, "there is no depth around it"});
      continue;
    }
    const auto plane = calibration::fit_plane(depth, model, *outline);
    if (!plane) {
      out.unused.push_back({camera_name, marker.name, plane.error().what});
      continue;
    }
    std::vector<Eigen::Vector2d> points = marker.corners;
    points.insert(points.begin(), marker.middle);
    for (std::size_t part = 0; part < points.size(); ++part) {
      calibration::Sighting sighting;
      sighting.camera = camera;
      sighting.marker = static_cast<std::size_t>(named - marker_names.begin());
      sighting.part = static_cast<int>(part);
      sighting.ray = unproject(model, points[part], 1).head<2>();
      sighting.z_m = plane->z_along(sighting.ray);
      if (!(sighting.z_m > 0)) continue;  // a plane seen from its edge
      sighting.ray_sigma = marker.sigma_px / model.fx;
      if (part > 0) sighting.inverse_z_sigma = calibration::kUnknownDepth;
      if (part == 0) out.depths.push_back({marker.name, *plane, sighting.z_m});
      out.sightings.push_back(sighting);
    }
  }
  return out;
}

}  // namespace copresence::calibrate
