#pragma once

// Private to this folder: soft shadows of a figure's capsules in the light of a round lamp.
// Thread: free functions on const arguments are safe anywhere.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "simulation/scene/figure.h"

namespace copresence::simulation {

/// Radius of the lamp in metres. The radius determines how soft shadows are.
inline constexpr float kLampRadius = 0.2f;

/// Points that may be in shadow, in metres in the world frame. Separate arrays let loops vectorise.
struct ShadowPoints {
  std::vector<float> x, y, z;
  Eigen::Vector3f lamp = Eigen::Vector3f::Zero();
  std::vector<float> to_x, to_y, to_z;  ///< Unit direction to the lamp.
  std::vector<float> distance;          ///< Distance to the lamp.

  std::size_t size() const { return x.size(); }
  void resize(std::size_t count);
  void add(const Eigen::Vector3f& position);

  /// Sets `lamp`, and the direction and distance of every point.
  void aim_at(const Eigen::Vector3f& lamp_center);
};

/// Computes the share of the lamp that the capsules hide from each point, 0 to 1. The function is
/// fastest if consecutive points are close to each other. Requires an earlier
/// ShadowPoints::aim_at() and one element of `hidden` per point.
void cast_shadows(const ShadowPoints& points, std::span<const Capsule> capsules, float lamp_radius,
                  std::span<float> hidden);

}  // namespace copresence::simulation
