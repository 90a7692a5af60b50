#pragma once

// Which points of two cameras' surfaces are the same place, by projecting one camera's points into the other's picture.
//
// Thread: pure.

#include <Eigen/Core>
#include <vector>

#include "common/frame/rigid3.h"
#include "tools/calibrate/alignment/surface.h"

namespace copresence::alignment {

struct Match {
  Eigen::Vector3d a, b;          ///< the two points, world, metres
  Eigen::Vector3d normal;        ///< mean of both normals, world, length 1
  int pixel_a = 0, pixel_b = 0;  ///< where in either picture: y * width + x
  double sigma = 0;              ///< expected error of the distance along the normal, metres
  double distance() const { return normal.dot(a - b); }
};

struct MatchRules {
  int spacing = 4;            ///< pixels between the points that are projected
  double reach_m = 0.05;      ///< farthest distance along the target's normal, on top of three sigmas
  double least_cosine = 0.7;  ///< between the two normals
};

/// Appends the points of `a` that meet `b`'s surface, at most one per projected pixel.
void append_matches(const Surface& a, const Rigid3& world_from_a, const Surface& b,
                    const Rigid3& world_from_b, const MatchRules& rules, std::vector<Match>& matches);

}  // namespace copresence::alignment
