#pragma once

// Rate controller for depth: keeps picture and side data together at a bit rate.
//
// x264 keeps the pictures below its rate, but it spends slightly less than allowed and does not
// count the side data. So each picture gets its own rate: the nominal rate minus the side data,
// corrected by the level of a leaky bucket. The level is the number of bits that earlier frames
// spent above the rate. Thread: distinct objects are independent.

#include <cstddef>

#include "common/video/picture_encoder.h"

namespace copresence::video {

class DepthRateController {
 public:
  /// Requires kbps > 0, frames_per_second > 0.
  DepthRateController(int kbps, double frames_per_second);

  void set_kbps(int kbps);

  /// Returns the rate for the picture of a frame that has `side_bytes` bytes of side data.
  PictureRate picture_rate(std::size_t side_bytes) const;

  /// Counts `bytes`, the size of a whole frame.
  void spent(std::size_t bytes);

 private:
  double frame_bits() const;  // Mean size of a frame in bits.

  double kbps_;
  double frames_per_second_;
  double bucket_bits_ = 0;  // Bits spent above the rate; negative if saved.
};

}  // namespace copresence::video
