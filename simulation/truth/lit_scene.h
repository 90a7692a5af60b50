#pragma once

// A scene with its light computed, ready for tracing.
//
// Light on static surfaces is computed once per vertex: direct light of the lamps with soft
// shadows, and one diffuse reflection (a radiosity gather). This light is the same from every
// viewpoint and free of noise. Here light is the radiance of a white diffuse surface; 1 is the
// brightest value of a display.
//
// Thread: immutable, so any thread may use it.

#include <Eigen/Core>
#include <memory>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "simulation/scene/scene.h"
#include "simulation/truth/ray_tracer.h"

namespace copresence::simulation {

/// Light at a point. The first lamp's part is separate, because the figure shades it.
struct Light {
  Eigen::Vector3f lamp = Eigen::Vector3f::Zero();
  Eigen::Vector3f rest = Eigen::Vector3f::Zero();
};

struct BakedLight {
  std::vector<std::vector<Light>> vertices;                  ///< Light as [mesh][vertex].
  Eigen::Vector3f reflected_mean = Eigen::Vector3f::Zero();  ///< Mean reflected light of all vertices.
};

class LitScene {
 public:
  /// Creates the scene of a world. Fails as make_scene() and make() do.
  static Result<LitScene> of_world(std::string_view name);

  /// Fails with kUnsupported if Embree cannot start.
  static Result<LitScene> make(Scene scene);

  const Scene& scene() const { return scene_; }
  const Figure& figure() const { return scene_.figure; }
  const RayScene& background() const { return *background_; }  ///< Tracer for Scene::meshes.
  const PosedScene::Parts& figure_parts() const { return *figure_parts_; }
  const BakedLight& light() const { return light_; }

 private:
  Scene scene_;
  std::shared_ptr<const RayScene> background_;
  std::shared_ptr<const PosedScene::Parts> figure_parts_;
  BakedLight light_;
};

}  // namespace copresence::simulation
