#pragma once

// Corrects the upper bits of spiral-coded depth from spatial continuity. The lower bits are
// reliable, since luma has the full resolution. The upper bits are wrong if other pixels of the
// chroma sample outvoted the pixel, or if video coding moved the sample to another point. A wrong
// pixel differs from the pixels on both sides of its chroma sample. If other upper bits bring the
// pixel close to one side, it takes these bits. A pixel at a true edge agrees with one side and is
// not changed. Thread: pure.

#include "common/frame/image.h"

namespace copresence::depth {

/// Corrects 13-bit depth in place, in the chroma samples that are not 0 in `doubtful`. `doubtful`
/// has the shape of the chroma planes. If `fold` is true, the lower bits are mirrored, as in the
/// codec's -fold variants. Holes are neither used nor changed.
void correct_upper_bits(DepthImage& coded, const StateImage& states, const Image<std::uint8_t>& doubtful,
                        bool fold);

}  // namespace copresence::depth
