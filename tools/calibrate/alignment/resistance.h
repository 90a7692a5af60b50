#pragma once

// Which motions of the cameras the matched surfaces resist, and which they let slide.
//
// Thread: pure.

#include <Eigen/Core>

#include "tools/calibrate/alignment/descent.h"

namespace copresence::alignment {

struct Resistances {
  Eigen::MatrixXd directions;  ///< columns, orthonormal: motions of all moving cameras
  Eigen::VectorXd values;      ///< of each column; see Direction in refinement.h
};

/// `equations` with rows kept.
Resistances measure_resistance(const Equations& equations);

}  // namespace copresence::alignment
