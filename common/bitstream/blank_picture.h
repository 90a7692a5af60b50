#pragma once

// Writes H.264 access units of blank pictures: uniform grey, a few bytes each. They carry the side
// data of frames whose depth is coded as residuals instead of a picture. So the stream remains
// valid H.264 for programs that copy, store or show it. libx264 takes 0.6 ms for each of these
// pictures at 640x480, and this writer less than a microsecond between keyframes.
//
// Each picture is one slice. Keyframes are predicted from mid grey without a residual; other
// pictures repeat the one before.
// Source: ITU-T H.264 (08/2021), 7.3.2.1, 7.3.2.2, 7.3.3 and table 7-11. Thread: a value.

#include <cstdint>
#include <vector>

#include "common/frame/picture.h"

namespace copresence::bitstream {

class BlankPictureWriter {
 public:
  /// Requires kGray8 or kGray10, even sizes from 2 to 4096.
  BlankPictureWriter(PixelFormat format, int width, int height);

  /// The next access unit, Annex B. Requires a keyframe first.
  std::vector<std::uint8_t> write(bool keyframe);

 private:
  std::vector<std::uint8_t> sequence_parameters() const;

  PixelFormat format_;
  int width_, height_;
  unsigned frame_number_ = 0;  // since the last keyframe
  unsigned keyframes_ = 0;
};

}  // namespace copresence::bitstream
