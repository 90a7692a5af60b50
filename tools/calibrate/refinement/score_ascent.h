#pragma once

// Finds the poses of highest score by evaluating the score (NormalEquations::score) itself.
// ICP follows its current matches and ignores those that a step adds or removes. On perfect
// surfaces both methods end at the same pose. On real surfaces, object edges and moving objects
// pull the two to different sides of the truth. So the distance between both results reveals a
// systematic error that residuals do not show.
// The score is evaluated some millimetres to both sides along each principal direction of the
// matches. A parabola through the three values gives the step.
// Thread: pure functions; the same input gives the same output.

#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/icp.h"

namespace copresence::calibrate {

/// `poses` must be near the best ones, such as those of run_icp(). The score never decreases.
void maximise_score(const IcpProblem& problem, const IcpLevel& level, const FixedDirections& fixed,
                    std::vector<Rigid3>& poses);

}  // namespace copresence::calibrate
