#pragma once

// Finds the holes that are narrow enough to be closed. Thread: pure.

#include "common/frame/image.h"

namespace copresence::hole_filling {

/// Returns 1 for a hole in a run of at most `widest` holes, along its row or column, with depth at
/// both ends. Also 1 for a run of at most `widest_at_border` holes with depth at one end and the
/// image's border at the other. Else 0. Requires 1 <= widest <= 254 and 0 <= 2 widest_at_border <=
/// widest.
void find_fillable(const StateImage& state, int widest, int widest_at_border, Image<std::uint8_t>& fillable);

}  // namespace copresence::hole_filling
