#pragma once

// Fills holes so that the picture costs few bits in a video codec, which codes smooth and unchanged
// areas cheaply. Filled values are never shown, since the validity mask makes them holes again.
//
// A hole keeps its value from the frame before, which H.264 can skip if the camera stands still.
// The hole is filled again if its value differs too much from its border, or if most of the picture
// moves. A filled hole takes the farther of the two depths at its ends in its row. Thread: distinct
// objects are independent.

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth {

class BackgroundFill {
 public:
  BackgroundFill(int width, int height, DepthRangeUnits range, DepthUnit unit, const DepthNoise& noise);

  /// Fills the holes of a frame. Depth outside the range becomes a hole. The result is in depth()
  /// and states(). Requires the shape given to the constructor.
  void take(const DepthImage& depth, const StateImage& states);

  const DepthImage& depth() const { return depth_; }  ///< Depth is within the range at every pixel.
  /// The input's states, but kHole where depth is outside the range.
  const StateImage& states() const { return states_; }

 private:
  // A run of holes in row y, in the columns `from` to `end` - 1.
  struct Gap {
    int y, from, end;
  };

  template <class Visit>
  void visit_gaps(const Visit& visit) const;
  void fill_anew(const Gap& gap);
  bool has_cliffs(const Gap& gap) const;
  bool moves_fast() const;
  void fill_rows_without_depth();
  double steps(int from, int to) const;  // Disparity steps between two depths.

  DepthRangeUnits range_;
  double steps_per_inverse_unit_;
  DepthImage depth_, earlier_;
  StateImage states_;
  bool first_ = true;  // True until the first frame has been filled.
};

}  // namespace copresence::depth
