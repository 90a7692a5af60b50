#pragma once

// Description of a stream. The server sends the description to the client once, before the first
// frame. Values that can change are sent with each frame instead.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/picture.h"
#include "common/frame/rigid3.h"

namespace copresence {

/// Name and parameters of a depth codec: all that its decoder needs besides the frames.
struct DepthCodecDescription {
  std::string name;                                        ///< For example quantized or spiral-fold.
  PixelFormat format = PixelFormat::kGray8;                ///< Format of the depth pictures.
  std::vector<std::pair<std::string, double>> parameters;  ///< See docs/internals/codecs.md.

  friend bool operator==(const DepthCodecDescription&, const DepthCodecDescription&) = default;
};

struct StreamDescription {
  std::string camera;  ///< The server's --name.
  CameraModel model;   ///< Model of depth, and of colour, which is registered to depth.
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  DepthNoise noise;               ///< Noise of the sensor.
  double frames_per_second = 30;  ///< Nominal frame rate.
  bool has_color = false;
  /// True if the server keeps static surfaces still before coding. False if it codes what the
  /// sensor measured: without the filter, and if the stream began lossless.
  bool is_temporally_filtered = false;
  bool has_pose = false;     ///< False if the server does not know its camera's pose.
  Rigid3 world_from_camera;  ///< Pose at the start of the stream; a frame's own pose takes precedence.
  DepthCodecDescription codec;

  friend bool operator==(const StreamDescription&, const StreamDescription&) = default;
};

}  // namespace copresence
