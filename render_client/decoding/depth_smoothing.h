#pragma once

// Smooths the noise of sensor and codec in a depth image before it becomes a surface. The depth
// levels of a Kinect are 25 mm apart at 3 m, and coding adds about one level. Seen from the side,
// the surface would be rough with ragged edges.
//
// Each value becomes the mean of its neighbours in the row, then in the column. Only neighbours on
// the same surface count: those within a few sensor steps. Holes and states stay, and nothing is
// averaged across a discontinuity.
//
// Thread: one thread at a time per object.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::decoding {

class DepthSmoothing {
 public:
  static constexpr int kRadius = 3;  ///< pixels
  static constexpr float kSameSurface =
      2.5f;  ///< sensor steps between a pixel and a neighbour on its surface

  /// Changes only values that are not 0, by at most kSameSurface steps in each direction.
  void smooth(DepthImage& depth, DepthUnit unit, const DepthNoise& noise);

 private:
  std::vector<std::uint16_t> rows_;        // some rows and their neighbours, smoothed along the row
  std::vector<std::uint16_t> padded_;      // one row, with kRadius empty pixels at both ends
  std::vector<std::uint16_t> tolerances_;  // these three are of one row, in whole groups of pixels
  std::vector<std::int16_t> sums_, shares_;
};

}  // namespace copresence::decoding
