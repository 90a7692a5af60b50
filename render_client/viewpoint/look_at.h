#pragma once

// Computes the pose of an eye that looks at a target. Thread: pure functions.

#include <Eigen/Core>

#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

/// Returns the pose of an eye at `eye` that looks at `target`. `up` points upward in its picture,
/// and has any length. All arguments are world coordinates in metres. The result is a rigid pose
/// even if eye and target are equal, or if `up` is zero or parallel to the view.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

}  // namespace copresence::viewpoint
