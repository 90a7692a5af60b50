#pragma once

// Camera metadata that the .oni format lacks: the full camera model, the pose, and whether colour
// is registered to depth. It is stored as JSON in the general property kCameraMetadataProperty of
// the depth node. Other players skip it.
//
//   {"name":"camera0","width":640,"height":480,"fx":585.5,"fy":585.5,"cx":319.5,"cy":239.5,
//    "distortion":[k1,k2,p1,p2,k3,k4,k5,k6],"registered":true,"unit_um":1000,
//    "world_from_camera":[[r,r,r,t],[r,r,r,t],[r,r,r,t],[0,0,0,1]],
//    "color":{"width":...,"color_from_depth":[[r,r,r,t],[r,r,r,t],[r,r,r,t],[0,0,0,1]]}}
//
// Thread: free functions on values, safe anywhere.

#include <optional>
#include <string>
#include <string_view>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rigid3.h"
#include "common/result.h"

namespace copresence::recording {

/// The colour camera, if it is not the depth camera.
struct ColorCameraMetadata {
  CameraModel model;
  Rigid3 color_from_depth;  ///< metres
  friend bool operator==(const ColorCameraMetadata&, const ColorCameraMetadata&) = default;
};

struct CameraMetadata {
  std::string name;         ///< the camera's name; may be empty
  CameraModel model;        ///< of depth and, when registered, of colour
  bool registered = false;  ///< colour has depth's camera model
  DepthUnit unit = DepthUnit::kMillimetre;
  std::optional<Rigid3> world_from_camera;  ///< metres; absent if unknown
  /// Only if not registered; absent if unknown.
  std::optional<ColorCameraMetadata> color = std::nullopt;

  friend bool operator==(const CameraMetadata&, const CameraMetadata&) = default;
};

/// One line of JSON. Doubles keep every bit. Requires a model that check() accepts.
std::string to_json(const CameraMetadata& note);

/// The inverse of to_json(); unknown keys are ignored.
/// Fails  kCorrupt: bad JSON, a missing key, an invalid camera model, a pose that is no rigid
///        transform, or more than 64 KiB.
Result<CameraMetadata> parse_camera_metadata(std::string_view json);

}  // namespace copresence::recording
