#pragma once

// Rate controller for depth: keeps picture and side data together at a bit rate.
//
// x264 keeps the pictures below its rate, but spends a little less than allowed, and does not count
// the side data. So each picture gets a rate of its own: the nominal rate less the side data,
// corrected by the bucket level. The bucket level is what the frames so far have spent above the
// rate (a leaky bucket). Thread: a value.

#include <cstddef>

#include "common/video/picture_encoder.h"

namespace copresence::video {

class DepthRateController {
 public:
  /// Requires kbps > 0, frames_per_second > 0.
  DepthRateController(int kbps, double frames_per_second);

  void set_kbps(int kbps);

  /// The rate for the picture of a frame with so many bytes of side data.
  PictureRate picture_rate(std::size_t side_bytes) const;

  /// Counts the size of the whole frame.
  void spent(std::size_t bytes);

 private:
  double frame_bits() const;  // bits per frame at the rate

  double kbps_;
  double frames_per_second_;
  double bucket_bits_ = 0;  // bits spent above the rate; negative: saved
};

}  // namespace copresence::video
