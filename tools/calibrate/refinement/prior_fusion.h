#pragma once

// Combines the poses found on surfaces with given poses of known error: the most likely poses if
// both have normally distributed errors.
//
// The error of the surfaces comes from their own residuals: the sandwich estimator of Huber and
// White, with blocks of pixels as clusters. A pose of known error moves only if the surfaces are
// more accurate, and if surfaces that were left out of the fit agree better afterwards.
//
// Thread: pure.

#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/icp.h"

namespace copresence::calibrate {

struct FusedPose {
  enum class Verdict {
    kMoved,
    kPriorBetter,   ///< As given: the surfaces are not more accurate than the known error.
    kNotConfirmed,  ///< As given: surfaces left out of the fit do not agree better at the new pose.
  };
  Rigid3 pose;
  Verdict verdict = Verdict::kMoved;
  double surfaces_m = 0;     ///< Root mean square error of points among the matches, by the surfaces alone.
  double error_m = 0;        ///< The same of `pose`; 0 if unknown because some directions are fixed.
  bool contradicts = false;  ///< The surfaces disagree with the given pose by more than both errors explain.
};

/// Paired t score of the surfaces' agreement at `poses` against that at `others`, with one pair of
/// values per block. Below -2 they agree worse, by more than chance.
double paired_t_score(const IcpProblem& problem, std::span<const Rigid3> poses,
                      std::span<const Rigid3> others);

/// given, errors_m  of all cameras, as in refine().
/// found            the poses by the surfaces alone: the result of run_icp() with `fixed`.
/// Returns          one pose per camera of problem.moving. Poses of unknown error are those found,
///                  corrected for the movement of the others.
std::vector<FusedPose> fuse_with_prior(const IcpProblem& problem, const FixedDirections& fixed,
                                       std::span<const Rigid3> given, std::span<const double> errors_m,
                                       std::span<const Rigid3> found);

}  // namespace copresence::calibrate
