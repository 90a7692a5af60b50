#pragma once

// Which holes are narrow enough to be closed. Thread: pure.

#include "common/frame/image.h"

namespace copresence::hole_filling {

/// 1 where a hole lies in a run of at most `widest` holes, along its row or along its column, that has depth
/// at both ends; 0 elsewhere. Runs that touch the image's border have depth at one end at most. Requires 1 <=
/// widest <= 254.
void find_fillable(const StateImage& state, int widest, Image<std::uint8_t>& fillable);

}  // namespace copresence::hole_filling
