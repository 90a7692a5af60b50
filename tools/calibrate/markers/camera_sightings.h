#pragma once

// From markers in the picture to sightings in space: rays by the lens's model, depth by the plane of each marker.
// Thread: pure functions.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "tools/calibrate/geometry/plane_depth.h"
#include "tools/calibrate/geometry/sighting.h"
#include "tools/calibrate/markers/found_marker.h"

namespace copresence::calibrate {

/// A marker that was seen but cannot be used, and why.
struct Unused {
  std::string camera, marker, why;
};

struct MarkerDepth {
  std::string marker;
  calibration::PlaneFit plane;
  double z_m = 0;  ///< at its middle
};

struct CameraSightings {
  std::vector<calibration::Sighting> sightings;
  std::vector<MarkerDepth> depths;
  std::vector<Unused> unused;
};

/// marker_names  of the world, in the order of their numbers; holds every marker that is given.
/// A clicked marker has no outline: its depth is that of a disc of `kClickRadius` metres around the click.
inline constexpr double kClickRadius = 0.05;
CameraSightings sightings_of(std::size_t camera, const std::string& camera_name, const CameraModel& model,
                             std::span<const FoundMarker> markers, const calibration::DepthAverage& depth,
                             const std::vector<std::string>& marker_names);

}  // namespace copresence::calibrate
