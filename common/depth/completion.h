#pragma once

// Fills holes for coding only: a video codec wants a picture without cliffs and without change where nothing
// is to be seen. What stands in a hole is never shown, since the state mask makes it a hole again.
//
// A hole keeps what stood there in the completed picture before: where the camera stands still, H.264 then
// skips it. What never was anything is filled along its row from the farther side.
//
// Thread: distinct objects are independent.

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth {

class Completion {
 public:
  Completion(int width, int height, DepthRangeUnits range);

  /// Takes a frame in: everything outside the range counts as a hole. Afterwards depth() and states() hold
  /// it. Requires the shape given to the constructor.
  void take(const DepthImage& depth, const StateImage& states);

  const DepthImage& depth() const { return depth_; }  ///< within the range at every pixel
  const StateImage& states() const {
    return states_;
  }  ///< the input's, and kHole where depth lay outside the range

 private:
  void fill_along_rows();

  DepthRangeUnits range_;
  DepthImage depth_;  // 0 where nothing ever was
  StateImage states_;
  bool gaps_ = true;  // whether depth_ holds zeros
};

}  // namespace copresence::depth
