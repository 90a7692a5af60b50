#pragma once

// Which holes are narrow enough to be closed. Thread: pure.

#include "common/frame/image.h"

namespace copresence::hole_filling {

/// 1 where a hole lies in a run of at most `widest` holes, along its row or along its column, that has depth at both
/// ends; or in one of at most `widest_at_border` that has depth at one end and the image's border at the other. 0
/// elsewhere. Requires 1 <= widest <= 254 and 0 <= 2 widest_at_border <= widest.
void find_fillable(const StateImage& state, int widest, int widest_at_border, Image<std::uint8_t>& fillable);

}  // namespace copresence::hole_filling
