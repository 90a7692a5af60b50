#pragma once

// How one camera stands to another, from points that both have measured: the rigid least-squares form, and the thesis's
// linear one with 12 unknowns, which lets scale and shear take up noise and needs points in all directions.
//
// Thread: pure functions.

#include <Eigen/Core>
#include <span>

#include "common/frame/rigid3.h"

namespace copresence::calibration {

struct PointPair {
  Eigen::Vector3d in_a, in_b;  ///< metres
  double weight = 1;           ///< inverse variance, in any unit
};

/// b_from_a with the least weighted sum of squared distances. Requires three pairs that are not on one line.
/// Source   Umeyama 1991, without scale.
Rigid3 fit_rigid(std::span<const PointPair> pairs);

/// The affine map that takes points of a to b, and the rigid transform nearest to it.
struct LinearFit {
  Eigen::Matrix<double, 3, 4> b_from_a;    ///< as solved: metres
  Rigid3 rigid;                            ///< nearest rotation; the points' centres of gravity meet
  double least_scale = 1, most_scale = 1;  ///< singular values of its 3x3: 1 and 1 for a rotation
};

/// The thesis's 12 unknowns by least squares, unweighted as there. Requires four pairs that are not in one plane.
/// Source   thesis appendix A.2, eq. 3.4 and 3.5; its 3n x 12 system falls apart into three of n x 4.
LinearFit fit_linear(std::span<const PointPair> pairs);

/// Root mean square distance, metres, that `b_from_a` leaves between the pairs.
double rms_distance(const Rigid3& b_from_a, std::span<const PointPair> pairs);

}  // namespace copresence::calibration
