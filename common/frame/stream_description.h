#pragma once

// Description of a stream, sent to the client once before its first frame. Values that can change
// are sent with each frame instead.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/picture.h"
#include "common/frame/rigid3.h"

namespace copresence {

/// A depth codec's name and parameters: all that its decoder needs besides the frames.
struct DepthCodecDescription {
  std::string name;                                        ///< quantized, accuracy10, spiral-fold, ...
  PixelFormat format = PixelFormat::kGray8;                ///< of the depth pictures
  std::vector<std::pair<std::string, double>> parameters;  ///< documented in docs/internals/codecs.md

  friend bool operator==(const DepthCodecDescription&, const DepthCodecDescription&) = default;
};

struct StreamDescription {
  std::string camera;  ///< the server's --name
  CameraModel model;   ///< of depth, and of colour, which is registered to depth
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  DepthNoise noise;               ///< of the sensor
  double frames_per_second = 30;  ///< nominal
  bool has_color = false;
  bool has_pose = false;     ///< false: the server does not know its camera's pose
  Rigid3 world_from_camera;  ///< at the start of the stream; a frame's own metadata takes precedence
  DepthCodecDescription codec;

  friend bool operator==(const StreamDescription&, const StreamDescription&) = default;
};

}  // namespace copresence
