#pragma once

// Finds the holes that are narrow enough to be filled.
// Thread: a pure function, safe anywhere.

#include "common/frame/image.h"

namespace copresence::hole_filling {

/// Sets `fillable` to 1 for each hole in a short run along its row or column, else to 0. A run of
/// up to `widest` holes is short if depth lies at both ends. A run of up to `widest_at_border`
/// holes is short if depth lies at one end and the image's border at the other.
/// Requires `widest` from 1 to 254 and `widest_at_border` from 0 to widest / 2.
void find_fillable(const StateImage& state, int widest, int widest_at_border, Image<std::uint8_t>& fillable);

}  // namespace copresence::hole_filling
