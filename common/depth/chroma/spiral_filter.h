#pragma once

// Corrects the upper bits of spiral-coded depth from spatial continuity. The lower bits are
// reliable, since luma has the full resolution. The upper bits are wrong if the pixel lost the vote
// on its chroma sample, or if video coding moved the sample to another point. Such a pixel differs
// from the pixels on both sides of its chroma sample. If other upper bits bring it close to one
// side, it takes these. A pixel at a true edge agrees with one side and stays as it is. Thread:
// pure.

#include "common/frame/image.h"

namespace copresence::depth {

/// Corrects 13-bit depth in place, in the chroma samples that are not 0 in `doubtful`. `doubtful`
/// has the shape of the chroma planes. `fold`: the lower bits are mirrored, as in the codec's -fold
/// variants. Holes are neither used nor changed.
void correct_upper_bits(DepthImage& coded, const StateImage& states, const Image<std::uint8_t>& doubtful,
                        bool fold);

}  // namespace copresence::depth
