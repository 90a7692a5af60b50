#pragma once

// Poses that are known to some error against what the surfaces say: the most likely ones when both err as they tell.
//
// How far the surfaces may be off is read from their own residuals: what they add up to over a block is alike, from
// block to block it is independent (the sandwich of Huber and White, clustered). A pose that is known stays exactly
// as given unless the surfaces know more, and unless surfaces that had no part in the fit agree better afterwards.
//
// Thread: pure.

#include <span>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/descent.h"

namespace copresence::alignment {

struct Weighed {
  enum class Verdict {
    kMoved,
    kKnownBetter,   ///< as given: the surfaces tell the pose no better than it is known
    kNotConfirmed,  ///< as given: what was left out of the fit agrees no better where the fit puts it
  };
  Rigid3 pose;
  Verdict verdict = Verdict::kMoved;
  double surfaces_m = 0;  ///< how far off the surfaces alone leave points among the matches, root mean square
  double error_m = 0;     ///< the same of `pose`; 0 where nobody knows, parts of it being frozen
  bool contradicts = false;  ///< the surfaces lie farther from the given pose than both errors explain
};

/// How much better the surfaces agree at `poses` than at `others`, in standard errors of the difference, block by block:
/// below some -2 they agree worse, and not by chance.
double advantage(const Problem& problem, std::span<const Rigid3> poses, std::span<const Rigid3> others);

/// given, errors_m  of all cameras, as in refine().
/// found            where the surfaces alone put them; ends of descend() with `frozen`.
/// Returns          one per camera of problem.moving. Poses of unknown error are those found, or what follows from
///                  the others.
std::vector<Weighed> weigh(const Problem& problem, const Frozen& frozen, std::span<const Rigid3> given,
                           std::span<const double> errors_m, std::span<const Rigid3> found);

}  // namespace copresence::alignment
