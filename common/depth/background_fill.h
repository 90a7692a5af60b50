#pragma once

// Fills holes for coding only: a video codec wants a picture without cliffs and without change where nothing
// is to be seen. What stands in a hole is never shown, since the state mask makes it a hole again.
//
// A hole keeps what stood there in the completed picture before: where the camera stands still, H.264 then
// skips it. Where that has become a cliff against the hole's rim, and everywhere while the camera turns fast,
// it is filled anew along its row, from the farther side.
//
// Thread: distinct objects are independent.

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth {

class BackgroundFill {
 public:
  BackgroundFill(int width, int height, DepthRangeUnits range, DepthUnit unit, const DepthNoise& noise);

  /// Takes a frame in: everything outside the range counts as a hole. Afterwards depth() and states() hold
  /// it. Requires the shape given to the constructor.
  void take(const DepthImage& depth, const StateImage& states);

  const DepthImage& depth() const { return depth_; }  ///< within the range at every pixel
  const StateImage& states() const {
    return states_;
  }  ///< the input's, and kHole where depth lay outside the range

 private:
  // A run of holes in a row: columns from to before end.
  struct Gap {
    int y, from, end;
  };

  template <class Visit>
  void visit_gaps(const Visit& visit) const;
  void fill_anew(const Gap& gap);
  bool has_cliffs(const Gap& gap) const;
  bool moves_fast() const;
  void fill_rows_without_depth();
  double steps(int from, int to) const;  // sensor steps between two depths

  DepthRangeUnits range_;
  double steps_per_inverse_unit_;
  DepthImage depth_, earlier_;
  StateImage states_;
  bool first_ = true;  // nothing to keep in any hole yet
};

}  // namespace copresence::depth
