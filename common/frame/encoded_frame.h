#pragma once

// A frame as H.264: what travels.

#include <cstdint>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence {

struct EncodedFrame {
  bool keyframe = false;            ///< both pictures are IDR, mask and table complete
  std::uint64_t sequence = 0;       ///< of the stamp inside `depth`, for whoever does not decode
  std::vector<std::uint8_t> depth;  ///< one access unit, Annex B; its SEI carries stamp, mask and table
  std::vector<std::uint8_t> color;  ///< one access unit of the same instant; empty where there is no colour
  StageDurations durations;
};

}  // namespace copresence
