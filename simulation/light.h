#pragma once

// Light, kept per vertex of the still world: direct from its lamps with soft shadows, and once reflected from
// everything else (a radiosity gather), so that corners darken and colours bleed. What stands in a room is
// lit the same from every viewpoint, without noise.
//
// "Light" here is what a white, dull surface would show: 1 is as bright as a screen gets.
// Thread: values; free functions on const arguments are safe anywhere.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "simulation/figure.h"
#include "simulation/furnishing.h"
#include "simulation/ray_scene.h"

namespace copresence::simulation {

/// Light at one place. That of the first lamp is apart, since moving things shade it.
struct Light {
  Eigen::Vector3f lamp = Eigen::Vector3f::Zero();
  Eigen::Vector3f rest = Eigen::Vector3f::Zero();
};

struct BakedLight {
  std::vector<std::vector<Light>> vertices;  ///< of mesh, of vertex
  Eigen::Vector3f reflected_mean =
      Eigen::Vector3f::Zero();  ///< over all vertices: what surrounds the room's middle
};

BakedLight bake_light(const Furnishing& world, const RayScene& scene);

/// Places that moving things may shade from the first lamp, coordinate by coordinate so that many are computed at once.
struct ShadowPoints {
  std::vector<float> x, y, z;  ///< of the place, metres
  Eigen::Vector3f lamp = Eigen::Vector3f::Zero();
  std::vector<float> to_x, to_y, to_z;  ///< direction to the lamp, length 1
  std::vector<float> distance;          ///< to the lamp

  std::size_t size() const { return x.size(); }
  void resize(std::size_t count);
  void add(const Eigen::Vector3f& position);

  /// Fills in the way to the lamp from every place.
  void aim_at(const Eigen::Vector3f& lamp_center);
};

/// Places on moving things.
struct MovingPoints {
  ShadowPoints places;
  std::vector<float> normal_x, normal_y, normal_z;  ///< length 1

  void resize(std::size_t count);
};

/// Light at such places before anything shades it: what Light is, channel by channel.
struct MovingLight {
  std::array<std::vector<float>, 3> lamp, rest;
};

/// Lamps as points, the rest from the room's mean, more from above than from below.
void light_at(const Furnishing& world, const BakedLight& baked, const MovingPoints& points,
              MovingLight& light);

/// How much of a round lamp of radius `lamp_radius` the capsules hide from each point, 0 to 1, soft at the
/// edges. Quickest where points that follow each other are near each other. Requires aimed points.
void shade(const ShadowPoints& points, std::span<const Capsule> capsules, float lamp_radius,
           std::span<float> hidden);

}  // namespace copresence::simulation
