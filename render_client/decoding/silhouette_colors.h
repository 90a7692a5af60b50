#pragma once

// Removes the colour of a near surface from the farther one beside a depth edge. A Kinect's depth
// edges are several pixels off, and its two cameras never agree exactly. A background pixel with the
// colour of the person in front would paint the person's outline on the wall.
//
// Along each row and then each column, every depth edge is examined on its own. It may lie between
// two neighbours, or be a gap of holes, which belong to the farther surface. The colours of both
// surfaces are those a few pixels away from the edge. Pixels of the farther surface within kReach of
// the edge get its colour if theirs is clearly that of the nearer surface. Beside a gap wider than
// kWidestGap, the gap itself is the farther surface. Depth is never changed.
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
  static constexpr int kReach = 3;             ///< pixels of the farther surface beside an edge
  static constexpr int kWidestGap = 8;         ///< holes between the two surfaces of an edge
  static constexpr float kEdgeSteps = 8;       ///< sensor steps between the two surfaces, at least
  static constexpr float kLeastContrast = 40;  ///< distance of the two colours in RGB, of 255

  /// Does nothing to a frame without colour.
  void apply(RgbdFrame& frame, DepthUnit unit, const DepthNoise& noise);

 private:
  /// Pixels of the frame along a row or a column: pixel i has the index first + i * step.
  struct Line {
    std::ptrdiff_t first, step;
    int length;
    std::ptrdiff_t index(int i) const { return first + i * step; }
  };
  void find_edges(RgbdFrame& frame, int y, bool across);
  void separate(RgbdFrame& frame, Line line, int at) const;

  float edge_ = 0;                   // inverse depth, in 1/units
  std::vector<float> inverse_;       // of a row and the next one, in 1/units; 0 for holes
  std::vector<std::uint8_t> edges_;  // of a row: 1 where an edge may follow the pixel
};

}  // namespace copresence::decoding
