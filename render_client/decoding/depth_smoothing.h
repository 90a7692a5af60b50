#pragma once

// Takes a sensor's and a codec's grain out of depth before it becomes a surface. A Kinect's levels lie 25 mm apart at
// 3 m and coding adds a level or so; seen from the side that is a rough surface with ragged edges.
//
// Each value becomes the mean of its neighbours along the row, then along the column, as far as they lie on the same
// surface: within a few sensor steps. Holes stay holes, nothing is mixed across a discontinuity, states are kept.
// Thread: one thread at a time per object.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::client {

class DepthSmoothing {
 public:
  static constexpr int kRadius = 3;  ///< pixels
  static constexpr float kSameSurface =
      2.5f;  ///< sensor steps between a pixel and a neighbour of its surface

  /// Changes depth only where it is not 0, by at most kSameSurface steps each way.
  void smooth(DepthImage& depth, DepthUnit unit, const DepthNoise& noise);

 private:
  std::vector<std::uint16_t> rows_;    // some of the rows, smoothed along themselves, with their neighbours
  std::vector<std::uint16_t> padded_;  // one row with kRadius empty pixels on both sides
  std::vector<std::uint16_t> tolerances_;  // of one row, in whole groups of pixels, like...
  std::vector<std::int16_t> sums_, shares_;
};

}  // namespace copresence::client
