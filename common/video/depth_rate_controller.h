#pragma once

// Holds all that depth costs to a rate: what mask and table take, the picture gives up.
//
// x264 keeps a picture to the rate it is told, within its buffer, but spends a little less than it may and
// knows nothing of the side data. So each picture is told a rate of its own: the nominal one, less the side
// data, corrected by what the frames so far spent over or under it. Thread: a value.

#include <cstddef>

#include "common/video/picture_encoder.h"

namespace copresence::video {

class DepthRateController {
 public:
  /// Requires kbps > 0, frames_per_second > 0.
  DepthRateController(int kbps, double frames_per_second);

  void set_kbps(int kbps);

  /// What the picture of a frame may take whose side data takes `side_bytes`.
  PictureRate picture_rate(std::size_t side_bytes) const;

  /// Tells what the whole frame came to.
  void spent(std::size_t bytes);

 private:
  double frame_bits() const;  // a frame's share of the rate

  double kbps_;
  double frames_per_second_;
  double debt_bits_ = 0;  // spent so far beyond the rate; negative: saved
};

}  // namespace copresence::video
