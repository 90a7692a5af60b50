#pragma once

// What moves in a world: rigid parts. Mostly a person-like figure that stands, shifts its weight, waves and talks with
// its hands, on joints and in clothes.
//
// All motion has the period 1 in `phase`: phase 0 and phase 1 are the same pose, and so is the speed there.
// Thread: a value; pose() is pure.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "simulation/furnishing.h"
#include "simulation/mesh.h"

namespace copresence::simulation {

/// A part's shape in the rough, for soft shadows: a thick line in the part's own frame.
struct Capsule {
  Eigen::Vector3f from, to;
  float radius = 0;
};

struct Figure {
  std::vector<Mesh> parts;        ///< each in its own frame; a limb's joint at the origin, the limb along +y
  std::vector<Capsule> capsules;  ///< one per part
  Eigen::Isometry3f place =
      Eigen::Isometry3f::Identity();  ///< world_from_figure: between the feet, facing -z

  /// figure_from_part for every part; set where there are parts.
  std::vector<Eigen::Isometry3f> (*motion)(double phase) = nullptr;

  bool empty() const { return parts.empty(); }

  /// world_from_part for every part.
  std::vector<Eigen::Isometry3f> pose(double phase) const;
};

/// A grown person of 1.75 m in a plaid shirt, jeans and shoes; its materials are added to `world`.
Figure make_person(Furnishing& world);

}  // namespace copresence::simulation
