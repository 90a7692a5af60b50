#pragma once

// A still world being put together: surfaces and what they are made of, and where its light comes from.
// Thread: a value.

#include <Eigen/Core>
#include <vector>

#include "simulation/material.h"
#include "simulation/mesh.h"

namespace copresence::simulation {

/// A rectangle, center +- half_u +- half_v, that gives off light on the side from which u runs right and v
/// down.
struct AreaLight {
  Eigen::Vector3f center, half_u, half_v;
  Eigen::Vector3f power;  ///< light reaching a facing surface one metre away, linear colour
};

struct Furnishing {
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<AreaLight> lights;
  Eigen::Vector3f ambient =
      Eigen::Vector3f::Constant(0.1f);  ///< light from everywhere, before the solids shade it

  /// Returns the index that meshes name it by.
  int add(const Material& material) {
    materials.push_back(material);
    return static_cast<int>(materials.size()) - 1;
  }
  void add(Mesh mesh) { meshes.push_back(std::move(mesh)); }
};

/// The world "room": a living room of 4.8 m x 4.5 m x 2.6 m around the origin, its middle free for a person,
/// with parquet, rug, papered walls, window, curtain, door, shelf with books, sofa, table, chairs, plant,
/// pictures, a dark screen, a mirror-like vase and a ceiling lamp.
Furnishing furnish_room();

}  // namespace copresence::simulation
