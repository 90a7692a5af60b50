#pragma once

// What an .oni file has no slot for: the camera's full model, where it stands, and whether colour is
// registered to depth. It rides as JSON in the general property kCameraNoteProperty of the depth node; other
// players skip it.
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

/// The colour camera where it is not the depth camera.
struct ColorCameraNote {
  CameraModel model;
  Rigid3 color_from_depth;  ///< metres
  friend bool operator==(const ColorCameraNote&, const ColorCameraNote&) = default;
};

struct CameraNote {
  std::string name;         ///< of the camera; may be empty
  CameraModel model;        ///< of depth and, when registered, of colour
  bool registered = false;  ///< colour has depth's camera model
  DepthUnit unit = DepthUnit::kMillimetre;
  std::optional<Rigid3> world_from_camera;  ///< metres; absent when nobody told
  /// Only where not registered; absent when nobody told.
  std::optional<ColorCameraNote> color = std::nullopt;

  friend bool operator==(const CameraNote&, const CameraNote&) = default;
};

/// One line of JSON. Doubles keep every bit. Requires a model that check() accepts.
std::string to_json(const CameraNote& note);

/// The inverse of to_json(); keys it doesn't know are skipped.
/// Fails  kCorrupt for anything but such an object: bad JSON, a missing key, a model that check() refuses, a
/// pose that is
///        no rigid transform, more than 64 KiB.
Result<CameraNote> parse_camera_note(std::string_view json);

}  // namespace copresence::recording
