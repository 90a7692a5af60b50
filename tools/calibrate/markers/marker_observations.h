#pragma once

// Measures markers of a picture in space: rays by the camera model, depth by a plane fit to each
// marker. Thread: pure functions.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "tools/calibrate/geometry/observation.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/markers/marker_finder.h"

namespace copresence::calibrate {

/// A marker that was found but cannot be used, and the reason.
struct Unused {
  std::string camera, marker, why;
};

struct MarkerDepth {
  std::string marker;
  PlaneFit plane;
  double z_m = 0;  ///< At the marker's centre.
};

struct CameraObservations {
  std::vector<Observation> observations;
  std::vector<MarkerDepth> depths;
  std::vector<Unused> unused;
};

/// marker_names  names of all markers, by index; must contain every given marker.
/// A clicked marker has no outline: a plane is fitted to a disc of `kClickRadius` metres around the
/// click.
inline constexpr double kClickRadius = 0.05;
CameraObservations observations_of(std::size_t camera, const std::string& camera_name,
                                   const CameraModel& model, std::span<const FoundMarker> markers,
                                   const DepthAverage& depth, const std::vector<std::string>& marker_names);

}  // namespace copresence::calibrate
