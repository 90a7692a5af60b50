#pragma once

// Worlds of known answer for the tests of the simulator.

#include <memory>

#include "simulation/simulated_kinect.h"

namespace copresence::simulation {

inline CameraModel small_kinect() {
  return kinect_model(320, 240);
}

/// A wall without end at depth z_m across the z axis, with the given share of infrared that it returns.
inline Furnishing wall_at(float z_m, float infrared = 0.8f) {
  Furnishing furnishing;
  Material paint{Pattern::kPlain, srgb(0x808080), srgb(0x808080), 0.1f, 0, 0, infrared};
  furnishing.add(panel({0, 0, z_m}, {20, 0, 0}, {0, 20, 0}, furnishing.add(paint), 40));
  furnishing.lights.push_back({{0, -1, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {2, 2, 2}});
  return furnishing;
}

inline std::shared_ptr<const World> world_of(Furnishing furnishing) {
  return std::make_shared<const World>(World::of(std::move(furnishing)).value());
}

inline TrueView view_of(const std::shared_ptr<const World>& world, const CameraModel& model,
                        const Rigid3& pose = {}) {
  return TrueCamera::make(world, model, pose).value().still();
}

}  // namespace copresence::simulation
