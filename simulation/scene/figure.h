#pragma once

// The moving part of a scene: rigid parts on joints. In the world "room" the parts form a person
// who shifts weight, waves and gestures. The motion has the period 1 in `phase`: pose and velocity
// at phase 1 are those at phase 0.
// Thread: distinct objects are independent; pose() is safe on any thread.

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
  /// Each part has its own frame. A limb's joint is at the origin, and the limb extends along +y.
  std::vector<Mesh> parts;
  std::vector<Capsule> capsules;  ///< One capsule per part, in the frame of the part.

  /// Pose of the figure. The figure's origin is between its feet, and it faces -z.
  Eigen::Isometry3f world_from_figure = Eigen::Isometry3f::Identity();

  /// Returns figure_from_part for every part. The function is null only if the figure has no parts.
  std::vector<Eigen::Isometry3f> (*motion)(double phase) = nullptr;

  bool empty() const { return parts.empty(); }

  /// Returns world_from_part for every part.
  std::vector<Eigen::Isometry3f> pose(double phase) const;
};

struct Scene;

/// An adult of 1.75 m in a plaid shirt, jeans and shoes. Adds its materials to `scene`.
Figure make_person(Scene& scene);

}  // namespace copresence::simulation
