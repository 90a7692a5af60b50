#pragma once

// Plain generalised ICP, to compare refining with: nearest neighbours, plane to plane, one reach, no weights.
//
// Source: Segal, Haehnel and Thrun 2009; covariances from normals and epsilon as Open3D's default has them.
// Thread: pure.

#include <Eigen/Core>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::alignment {

/// Points and normals, one per cube of `cube_m`, camera frame, metres.
struct Cloud {
  std::vector<Eigen::Vector3d> points, normals;
};
Cloud make_cloud(const Surface& surface, double cube_m = 0.03);

/// Returns  target_from_source, from the one given. `reach_m` is the farthest that two points of a match may be apart.
Rigid3 generalized_icp(const Cloud& source, const Cloud& target, const Rigid3& target_from_source,
                       double reach_m, int iterations = 50);

}  // namespace copresence::alignment
