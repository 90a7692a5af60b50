#pragma once

// Plain generalised ICP for comparison with refinement. It matches nearest neighbours within one
// search distance, plane to plane, without weights.
//
// The source is Segal, Haehnel and Thrun 2009. Covariances come from normals, with Open3D's
// epsilon. Thread: pure functions.

#include <Eigen/Core>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/refinement/surface.h"

namespace copresence::calibrate {

/// Points and normals in the camera frame in metres. There is one point per cube of side `cube_m`.
struct Cloud {
  std::vector<Eigen::Vector3d> points, normals;
};
Cloud make_cloud(const Surface& surface, double cube_m = 0.03);

/// Returns an improved target_from_source. Matched points are at most `reach_m` apart.
Rigid3 generalized_icp(const Cloud& source, const Cloud& target, const Rigid3& target_from_source,
                       double reach_m, int iterations = 50);

}  // namespace copresence::calibrate
