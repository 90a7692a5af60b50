#pragma once

// Scenes with known ground truth for the tests of the simulation.

#include <memory>

#include "simulation/sensor/simulated_kinect.h"

namespace copresence::simulation {

inline CameraModel small_kinect() {
  return kinect_model(320, 240);
}

/// A large wall at depth z_m across the z axis that reflects the given share of infrared light.
inline Scene wall_at(float z_m, float infrared = 0.8f) {
  Scene scene;
  Material paint{Pattern::kPlain, srgb(0x808080), srgb(0x808080), 0.1f, 0, 0, infrared};
  scene.add(panel({0, 0, z_m}, {20, 0, 0}, {0, 20, 0}, scene.add(paint), 40));
  scene.lights.push_back({{0, -1, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {2, 2, 2}});
  return scene;
}

inline std::shared_ptr<const LitScene> world_of(Scene scene) {
  return std::make_shared<const LitScene>(LitScene::make(std::move(scene)).value());
}

inline TrueView view_of(const std::shared_ptr<const LitScene>& world, const CameraModel& model,
                        const Rigid3& pose = {}) {
  return TrueCamera::make(world, model, pose).value().background();
}

}  // namespace copresence::simulation
