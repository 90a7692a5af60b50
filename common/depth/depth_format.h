#pragma once

// The shape of a stream's depth, as both ends know it from the stream description.

#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::depth {

struct DepthFormat {
  int width = 0;  ///< even, 2 to 4096, as a camera's
  int height = 0;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthRange range;
  DepthNoise noise = {};

  DepthRangeUnits units() const { return to_units(range, unit); }
};

/// Fails (kInvalid) on sizes no camera has and on a range that is empty, upside down or not finite.
Result<void> check(const DepthFormat& format);

}  // namespace copresence::depth
