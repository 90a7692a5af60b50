#pragma once

// Finds the blocks of a camera's picture in which a surface moves.
//
// A block moves if a part of its pixels shows another depth than in the frame before. It counts as
// moving for some frames more, because the middle of an arm that moves sideways keeps its depth.
// Only a few rows of each block are compared, so detect() takes less than 1 % of a frame's
// rendering. Thread: one thread at a time.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::moving_surfaces {

/// Width and height of a block in pixels, for pictures of this width: 8 at 640 pixels. It is
/// 2^block_shift().
inline int block_shift(int picture_width) {
  return picture_width < 480 ? 2 : picture_width < 960 ? 3 : 4;
}

/// One element per block, row by row. It is 1 where a surface moves. Empty if nothing moves.
using MovingBlocks = Image<std::uint8_t>;

class MotionDetector {
 public:
  static constexpr float kSteps = 3;  ///< Smallest change of a moving pixel, in disparity steps.
  /// A block moves if at least this share of its compared pixels has changed.
  static constexpr float kChangedShare = 3.0F / 16;
  static constexpr int kFrames = 4;  ///< A block counts as moving for this number of frames.
  /// If a larger share of the blocks moves in a frame, the camera moves. Then no block counts.
  static constexpr float kCameraMoves = 0.4F;

  /// Forgets the last frame, and takes frames with depth in `unit` from now on.
  void begin(DepthUnit unit, const DepthNoise& noise);

  /// Compares the depths with those of the last call. The result includes the neighbours of moving
  /// blocks. It is valid until the next call. A picture of another size starts anew.
  const MovingBlocks& detect(const DepthImage& depth);

 private:
  static constexpr int kRows = 2;  // Number of compared rows in each block.

  void compare_row(const std::uint16_t* depth, std::uint16_t* last);
  int count_changes(int block_row);
  void widen();

  float limit_ = 0;  // Largest difference of depths a and b without motion, divided by a b.
  int shift_ = 0;
  DepthImage last_;                    // The last known depths of the compared rows.
  std::vector<std::uint8_t> changes_;  // By column: the number of changed pixels in a row of blocks.
  Image<std::uint8_t> remaining_;      // By block: the number of frames for which it still moves.
  MovingBlocks moving_;
};

}  // namespace copresence::moving_surfaces
