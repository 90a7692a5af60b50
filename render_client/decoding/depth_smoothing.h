#pragma once

// Smooths the noise of sensor and codec in a depth image before it becomes a surface. The depth
// levels of a Kinect are 25 mm apart at 3 m, and coding adds an error of about one level. Without
// smoothing, a surface looks rough when it is seen from the side.
//
// Two passes replace each value by a mean over its neighbours, first along rows, then along
// columns. Only neighbours within a few sensor steps count, so depth edges stay sharp. Holes and
// states do not change. Thread: one thread at a time per object.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::decoding {

class DepthSmoothing {
 public:
  static constexpr int kRadius = 3;  ///< Pixels.
  /// Neighbours on one surface differ by at most this many sensor steps.
  static constexpr float kSameSurface = 2.5f;

  /// Changes only values that are not 0, by at most kSameSurface steps per pass.
  void smooth(DepthImage& depth, DepthUnit unit, const DepthNoise& noise);

 private:
  std::vector<std::uint16_t> rows_;    // Rows that are already smoothed horizontally.
  std::vector<std::uint16_t> padded_;  // One row with kRadius empty pixels at both ends.
  std::vector<std::uint16_t> tolerances_;
  std::vector<std::int16_t> sums_, shares_;
};

}  // namespace copresence::decoding
