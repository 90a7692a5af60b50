#pragma once

// Corrects the upper bits of spiral-coded depth from spatial continuity. The lower bits, at full resolution
// in luma, are good; the upper bits, from chroma, are wrong where a chroma sample's vote went against a pixel
// or video coding moved a point to another. Such a pixel stands off from what lies on both sides of its
// chroma sample; if another upper part puts it next to one of them, that one is taken. A true edge agrees
// with one side and stays.
//
// Thread: pure.

#include "common/frame/image.h"

namespace copresence::depth {

/// `coded` holds 13-bit depth, corrected in place under the chroma samples that are not 0 in `doubtful`,
/// which has the shape of the chroma planes; `fold` as the lower bits were written. Holes are neither asked
/// nor changed.
void correct_upper_bits(DepthImage& coded, const StateImage& states, const Image<std::uint8_t>& doubtful,
                        bool fold);

}  // namespace copresence::depth
