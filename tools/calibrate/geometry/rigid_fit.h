#pragma once

// Finds the pose of one camera relative to another from points that both have measured. There are
// two methods: rigid least squares, and the thesis's linear equations for 12 unknowns. The linear
// method also fits scale and shear, which absorb noise. The linear method needs points that are not
// in one plane. Thread: pure functions.

#include <Eigen/Core>
#include <span>

#include "common/frame/rigid3.h"

namespace copresence::calibrate {

struct PointPair {
  Eigen::Vector3d in_a, in_b;  ///< The same point in the frames of both cameras, metres.
  double weight = 1;           ///< Inverse variance, in any unit.
};

/// Finds b_from_a with the smallest weighted sum of squared distances. Requires three pairs that
/// are not on one line.
/// Source: Umeyama 1991 without scale. Eigen::umeyama() does not support weights.
Rigid3 fit_rigid(std::span<const PointPair> pairs);

/// The affine map from points of a to points of b, and the rigid transform nearest to it.
struct LinearFit {
  Eigen::Matrix<double, 3, 4> b_from_a;    ///< The solution of the linear equations, metres.
  Rigid3 rigid;                            ///< Has the nearest rotation; maps the centroid of a to that of b.
  double least_scale = 1, most_scale = 1;  ///< Singular values of the 3x3 part; both are 1 for a rotation.
};

/// Solves for the thesis's 12 unknowns by unweighted least squares. Requires four pairs that are
/// not in one plane.
/// Source: thesis appendix A.2, eq. 3.4 and 3.5. For n pairs, its 3n x 12 system separates into
/// three of n x 4.
LinearFit fit_linear(std::span<const PointPair> pairs);

/// Root mean square distance of the pairs after applying `b_from_a`, metres.
double rms_distance(const Rigid3& b_from_a, std::span<const PointPair> pairs);

/// The matrix M with M x = v cross x.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

/// The rotation about the axis `v` by the angle |v|, radians.
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& v);

/// The rotation nearest to a product of rotations that rounding has made inexact.
Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& rotation);

}  // namespace copresence::calibrate
