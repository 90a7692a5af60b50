#pragma once

// The poses at which the surfaces agree most, looked for by the agreement itself rather than by its slope.
//
// descend() follows the matches that it has and does not see those that a step gains or loses. Where all surfaces were
// as they are measured, both would end in one place. They do not: the rims of what is round, what moved a little, and
// the edge of what both see count differently in the two, and pull them to different sides of the truth. How far they
// end apart so tells what no scatter of residuals tells. Here the agreement (Equations::gain) is measured some
// millimetres to both sides along each principal direction of the matches, and the poses step to the top of the
// parabola through it.
//
// Thread: pure; the same input gives the same output.

#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/descent.h"

namespace copresence::alignment {

/// poses  Requires poses near the best ones, as descend() leaves them. Never left with less gain than they came with.
void climb(const Problem& problem, const Level& level, const Frozen& frozen, std::vector<Rigid3>& poses);

}  // namespace copresence::alignment
