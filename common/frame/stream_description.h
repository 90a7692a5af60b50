#pragma once

// What a client must know of a stream before its first frame. Sent once; what can change travels with each
// frame.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/picture.h"
#include "common/frame/rigid3.h"

namespace copresence {

/// A depth codec by name with its numbers: everything its decoder needs beside the frames themselves.
struct DepthCodecDescription {
  std::string name;                          ///< design section 3: quantized, accuracy10, spiral-fold, ...
  PixelFormat format = PixelFormat::kGray8;  ///< of the depth pictures
  std::vector<std::pair<std::string, double>> parameters;  ///< documented in docs/internals/codecs.md

  friend bool operator==(const DepthCodecDescription&, const DepthCodecDescription&) = default;
};

struct StreamDescription {
  std::string camera;  ///< the server's --name
  CameraModel model;   ///< of depth and, where there is colour, of colour: they are registered
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  double frames_per_second = 30;  ///< nominal
  bool has_color = false;
  bool has_pose = false;     ///< false: nobody told the server where its camera stands
  Rigid3 world_from_camera;  ///< at the start of the stream; a frame's own stamp wins
  DepthCodecDescription codec;

  friend bool operator==(const StreamDescription&, const StreamDescription&) = default;
};

}  // namespace copresence
