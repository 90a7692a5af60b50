#pragma once

// Repairs flying pixels: lossy coding blurs depth edges, and a pixel between two surfaces hangs in the air that neither of them
// is in. A pixel more than 5 sensor steps from both sides of an edge of 10 steps or more, two pixels off to either side, takes the
// depth of a side that is clearly nearer to it. In the middle between the two it stays: taken for the wrong one it would be
// farther off than it is. Worth it from the quantiser on at which video coding blurs edges (depth_codec.h).
//
// Thread: distinct objects are independent.

#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth {

class EdgeRepair {
 public:
  EdgeRepair(DepthUnit unit, const DepthNoise& noise);

  /// Repairs along rows, then along columns. Requires no zeros.
  void repair(DepthImage& depth);

 private:
  void repair_row(std::uint16_t* row, const std::uint16_t* before, const std::uint16_t* here,
                  const std::uint16_t* behind, int count) const;

  float steps_per_inverse_unit_;
  std::vector<std::uint16_t> copy_;
};

}  // namespace copresence::depth
