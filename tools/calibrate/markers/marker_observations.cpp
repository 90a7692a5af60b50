#include "tools/calibrate/markers/marker_observations.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "tools/calibrate/geometry/quantile.h"

namespace copresence::calibrate {
namespace {

// Median depth around a click, so that the edge of another object has no effect.
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
  return 1 / median(std::move(near));
}

// The outline for the plane fit. The outline includes part of the marker's white rim, which returns
// depth even if the dark cells do not.
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

CameraObservations observations_of(std::size_t camera, const std::string& camera_name,
                                   const CameraModel& model, std::span<const FoundMarker> markers,
                                   const DepthAverage& depth, const std::vector<std::string>& marker_names) {
  CameraObservations out;
  for (const FoundMarker& marker : markers) {
    const auto named = std::find(marker_names.begin(), marker_names.end(), marker.name);
    assert(named != marker_names.end());
    const auto outline = outline_of(marker, model, depth);
    if (!outline) {
      out.unused.push_back({camera_name, marker.name, "there is no depth around it"});
      continue;
    }
    const auto plane = fit_plane(depth, model, *outline);
    if (!plane) {
      out.unused.push_back({camera_name, marker.name, plane.error().what});
      continue;
    }
    std::vector<Eigen::Vector2d> points = marker.corners;
    points.insert(points.begin(), marker.middle);
    for (std::size_t part = 0; part < points.size(); ++part) {
      Observation observation;
      observation.camera = camera;
      observation.marker = static_cast<std::size_t>(named - marker_names.begin());
      observation.part = static_cast<int>(part);
      observation.ray = unproject(model, points[part], 1).head<2>();
      observation.z_m = plane->z_along(observation.ray);
      if (!(observation.z_m > 0)) continue;  // The plane is seen edge-on.
      observation.ray_sigma = marker.sigma_px / model.fx;
      if (part > 0) observation.inverse_z_sigma = kUnknownDepth;
      if (part == 0) out.depths.push_back({marker.name, *plane, observation.z_m});
      out.observations.push_back(observation);
    }
  }
  return out;
}

}  // namespace copresence::calibrate
