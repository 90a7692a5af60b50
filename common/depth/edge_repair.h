#pragma once

// Repairs flying pixels: pixels that lossy coding has placed between two surfaces by blurring a
// depth edge. The two pixels at a distance of 2 on opposite sides of a flying pixel differ by at
// least 10 disparity steps. The flying pixel differs from both by more than 5 steps. A flying pixel
// takes the depth of the side that is clearly nearer. Pixels near the midpoint are not changed: on
// the wrong surface, their error would be larger. At fine QPs the repair would move more correct
// pixels than blurred ones, so the codec omits it. Thread: distinct objects are independent.

#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth {

class EdgeRepair {
 public:
  EdgeRepair(DepthUnit unit, const DepthNoise& noise);

  /// Repairs along rows, then along columns. Requires depth in every pixel.
  void repair(DepthImage& depth);

 private:
  void repair_row(std::uint16_t* row, const std::uint16_t* before, const std::uint16_t* here,
                  const std::uint16_t* behind, int count) const;

  float steps_per_inverse_unit_;
  std::vector<std::uint16_t> copy_;
};

}  // namespace copresence::depth
