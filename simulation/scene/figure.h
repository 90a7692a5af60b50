#pragma once

// What moves in a scene: rigid parts on joints. In the world "room" they form a person who shifts
// weight, waves and talks with the hands.
//
// Motion has the period 1 in `phase`: pose and velocity at phase 1 are those at phase 0.
// Thread: a value; pose() is pure.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "simulation/scene/mesh.h"

namespace copresence::simulation {

/// The approximate shape of a part, used for soft shadows: a line segment with a radius, in metres.
struct Capsule {
  Eigen::Vector3f from, to;
  float radius = 0;
};

struct Figure {
  /// Each part in its own frame. The joint of a limb is at the origin, the limb extends along +y.
  std::vector<Mesh> parts;
  std::vector<Capsule> capsules;  ///< one per part, in the frame of the part

  /// The origin of the figure is between its feet; it faces -z.
  Eigen::Isometry3f world_from_figure = Eigen::Isometry3f::Identity();

  /// Returns figure_from_part for every part. Not null if there are parts.
  std::vector<Eigen::Isometry3f> (*motion)(double phase) = nullptr;

  bool empty() const { return parts.empty(); }

  /// world_from_part for every part.
  std::vector<Eigen::Isometry3f> pose(double phase) const;
};

struct Scene;

/// An adult of 1.75 m in a plaid shirt, jeans and shoes. Adds its materials to `scene`.
Figure make_person(Scene& scene);

}  // namespace copresence::simulation
