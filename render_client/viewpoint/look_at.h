#pragma once

// Points the eye at a target.
//
// Thread: pure.

#include <Eigen/Core>

#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

/// The pose of an eye at `eye` that looks at `target`, with `up` upward in its picture. World
/// coordinates, metres; `up` has any length. The pose is rigid even if target and eye are equal,
/// `up` is 0, or `up` is parallel to the view. It then still looks at the target, if that is
/// possible.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

}  // namespace copresence::viewpoint
