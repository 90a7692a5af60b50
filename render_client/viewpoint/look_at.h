#pragma once

// Thread: pure.

#include <Eigen/Core>

#include "common/frame/rigid3.h"

namespace copresence::viewpoint {

/// The pose of an eye at `eye` that looks at `target` with `up` upward in its picture. World, metres; `up` of
/// any length. Where the direction says nothing (target at the eye, up of length 0) or up lies along it, the
/// eye still gets a rigid pose that keeps what is known: it looks at the target if there is one.
Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

}  // namespace copresence::viewpoint
