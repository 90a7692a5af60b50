#pragma once

// Finds the poses of highest score by evaluating the score itself.
//
// ICP follows the matches that it has, and ignores those that a step adds or removes. On perfect
// surfaces both methods end at the same pose. On real ones, object edges and moving objects pull
// the two to different sides of the truth. So the distance between the two results shows a
// systematic error, which no residual shows.
//
// The score (NormalEquations::score) is evaluated some millimetres to both sides along each
// principal direction of the matches. A parabola through the three values gives the step.
//
// Thread: pure; the same input gives the same output.

#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/icp.h"

namespace copresence::calibrate {

/// poses  Requires poses near the best ones, such as run_icp() returns. The score never decreases.
void maximise_score(const IcpProblem& problem, const IcpLevel& level, const FixedDirections& fixed,
                    std::vector<Rigid3>& poses);

}  // namespace copresence::calibrate
