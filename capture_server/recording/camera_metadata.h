#pragma once

// Camera metadata that the .oni format lacks: the full camera model, the pose, and whether colour
// is registered to depth. The metadata is stored as JSON in the general property
// kCameraMetadataProperty of the depth node. Other players ignore it.
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

/// The colour camera, if it differs from the depth camera.
struct ColorCameraMetadata {
  CameraModel model;
  Rigid3 color_from_depth;  ///< In metres.
  friend bool operator==(const ColorCameraMetadata&, const ColorCameraMetadata&) = default;
};

struct CameraMetadata {
  std::string name;         ///< The camera's name, or empty.
  CameraModel model;        ///< Camera model of depth, and of colour if `registered`.
  bool registered = false;  ///< Depth and colour share one camera model.
  DepthUnit unit = DepthUnit::kMillimetre;
  std::optional<Rigid3> world_from_camera;  ///< In metres. Nothing if the pose is unknown.
  /// The colour camera if it is known and colour is not registered.
  std::optional<ColorCameraMetadata> color = std::nullopt;

  friend bool operator==(const CameraMetadata&, const CameraMetadata&) = default;
};

/// Returns one line of JSON. Doubles keep every bit. Requires a model that check() accepts.
std::string to_json(const CameraMetadata& note);

/// The inverse of to_json(). Unknown keys are ignored.
/// Fails with kCorrupt on bad JSON, a missing key, an invalid camera model, a pose that is not a
/// rigid transform, or a text of more than 64 KiB.
Result<CameraMetadata> parse_camera_metadata(std::string_view json);

}  // namespace copresence::recording
