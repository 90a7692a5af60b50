#pragma once

// Combines poses found on surfaces with given poses of known error. The result is the most likely
// pose if both errors are normally distributed.
// The error of the surfaces comes from their own residuals, by the sandwich estimator of Huber and
// White with blocks of pixels as clusters. A pose of known error moves under two conditions: the
// surfaces are more accurate than that error, and surfaces left out of the fit agree better at the
// new pose. Thread: pure functions.

#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/icp.h"

namespace copresence::calibrate {

struct FusedPose {
  enum class Verdict {
    kMoved,
    kPriorBetter,   ///< Not moved: the surfaces are not more accurate than the known error.
    kNotConfirmed,  ///< Not moved: surfaces left out of the fit do not agree better.
  };
  Rigid3 pose;
  Verdict verdict = Verdict::kMoved;
  double surfaces_m = 0;  ///< RMS error of points among the matches, from the surfaces alone.
  double error_m = 0;     ///< RMS error of points at `pose`; 0 if directions are fixed.
  /// True if the surfaces differ from the given pose by more than both errors explain.
  bool contradicts = false;
};

/// Paired t score of the surfaces' agreement at `poses` against `others`, with one pair of values
/// per block. Below -2, `poses` agree worse by more than chance.
double paired_t_score(const IcpProblem& problem, std::span<const Rigid3> poses,
                      std::span<const Rigid3> others);

/// `given` and `errors_m` belong to all cameras, as in refine().
/// `found` has the poses by the surfaces alone: the result of run_icp() with `fixed`.
/// Returns one pose per camera of problem.moving. Poses of unknown error are the found ones,
/// corrected for the movement of the others.
std::vector<FusedPose> fuse_with_prior(const IcpProblem& problem, const FixedDirections& fixed,
                                       std::span<const Rigid3> given, std::span<const double> errors_m,
                                       std::span<const Rigid3> found);

}  // namespace copresence::calibrate
