#pragma once

// Computes the pose of an eye that looks at a target. Thread: pure functions.

#include <Eigen/Core>

#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

/// Returns the pose of an eye at `eye` that looks at `target`. `up` points upward in its picture,
/// and has any length. All arguments are world coordinates in metres. If the arguments are
/// degenerate, the result is still a rigid pose. It looks at the target unless target and eye are
/// equal.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

}  // namespace copresence::viewpoint
