#pragma once

// A frame as a video codec can carry it: pictures, and the bytes that must arrive exactly.

#include <cstdint>
#include <optional>
#include <vector>

#include "common/frame/picture.h"
#include "common/frame/rgbd_frame.h"

namespace copresence {

/// Depth as pictures: what a depth codec makes of a DepthImage and its states.
struct PlanarDepth {
  bool keyframe = false;  ///< needs nothing of earlier frames to be decoded
  Picture picture;  ///< lossy from here on; holes hold whatever is cheapest; empty where samples are not
  int quantiser =
      0;  ///< that video coding used, as H.264 counts it at the picture's depth; 0 where nothing was lost
  std::vector<std::uint8_t> samples;        ///< coded without loss, instead of the picture
  std::vector<std::uint8_t> validity_mask;  ///< coded states of all pixels, lossless
  std::vector<std::uint8_t> table;          ///< coded change of the level table; empty for codecs without one
};

struct PlanarFrame {
  FrameMetadata stamp;
  PlanarDepth depth;
  std::optional<Picture> color;  ///< kYuv420, full range BT.601
  StageDurations durations;
};

}  // namespace copresence
