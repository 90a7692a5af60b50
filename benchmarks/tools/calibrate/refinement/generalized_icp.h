#pragma once

// Plain generalised ICP, as a comparison for refinement: nearest neighbours, plane to plane, one
// search distance, no weights.
//
// Source: Segal, Haehnel and Thrun 2009, with covariances from normals and the epsilon of Open3D.
// Thread: pure functions.

#include <Eigen/Core>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

/// Points and normals in the camera frame, one per cube of side `cube_m`. Metres.
struct Cloud {
  std::vector<Eigen::Vector3d> points, normals;
};
Cloud make_cloud(const Surface& surface, double cube_m = 0.03);

/// Returns  target_from_source, from the one given. `reach_m` is the farthest that two points of a
///          match may be apart.
Rigid3 generalized_icp(const Cloud& source, const Cloud& target, const Rigid3& target_from_source,
                       double reach_m, int iterations = 50);

}  // namespace copresence::calibrate
