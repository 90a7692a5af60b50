#pragma once

// Removes the colour of a near surface from the farther surface beside a depth edge. A Kinect's
// depth edges are several pixels off, and its two cameras never agree exactly. A background pixel
// with the colour of the person in front would paint the person's outline on the wall.
//
// Every depth edge along each row, and then along each column, is examined on its own. An edge lies
// between two neighbours, or is a gap of holes, which belong to the farther surface. The colour of
// a surface is measured a few pixels away from the edge. Pixels of the farther surface within
// kReach of the edge get that surface's colour if they clearly have the colour of the nearer
// surface. A gap wider than kWidestGap is itself the farther surface. Depth is never changed.
//
// Thread: one thread at a time per object.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"

namespace copresence::decoding {

class SilhouetteColors {
 public:
  static constexpr int kReach = 3;             ///< Largest distance from the edge, in pixels.
  static constexpr int kWidestGap = 8;         ///< Largest width of an edge's gap, in pixels.
  static constexpr float kEdgeSteps = 8;       ///< Smallest edge, in disparity steps.
  static constexpr float kLeastContrast = 40;  ///< Smallest distance of the two colours, in 1/255.

  /// Does nothing to a frame without colour.
  void apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise);

 private:
  /// Pixels of the frame along a row or a column. Pixel i has the index first + i * step.
  struct Line {
    std::ptrdiff_t first, step;
    int length;
    std::ptrdiff_t index(int i) const { return first + i * step; }
  };
  void separate_row(RgbdFrame& frame, int y, bool across) const;
  void separate(RgbdFrame& frame, Line line, int at) const;

  float edge_ = 0;                   // Smallest edge in inverse depth, in 1/units.
  std::vector<float> above_, here_;  // Inverse depths of the last two rows.
  std::vector<std::uint8_t> edges_;  // Is 1 if an edge may follow the row's pixel.
};

}  // namespace copresence::decoding
