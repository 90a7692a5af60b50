#pragma once

// Measures markers in space: rays by the camera model, and depth by a plane fitted to each marker.
// Thread: pure functions.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "tools/calibrate/geometry/observation.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/markers/marker_finder.h"

namespace copresence::calibrate {

/// A marker that was found but is not used, and the reason.
struct Unused {
  std::string camera, marker, why;
};

struct MarkerDepth {
  std::string marker;
  PlaneFit plane;
  double z_m = 0;  ///< Depth at the marker's centre, metres.
};

struct CameraObservations {
  std::vector<Observation> observations;
  std::vector<MarkerDepth> depths;
  std::vector<Unused> unused;
};

/// `marker_names` are the names of all markers, by index. They must contain every given marker.
/// A clicked marker has no outline. A clicked marker's plane is fitted to a disc of `kClickRadius`
/// metres.
inline constexpr double kClickRadius = 0.05;
CameraObservations observations_of(std::size_t camera, const std::string& camera_name,
                                   const CameraModel& model, std::span<const FoundMarker> markers,
                                   const DepthAverage& depth, const std::vector<std::string>& marker_names);

}  // namespace copresence::calibrate
