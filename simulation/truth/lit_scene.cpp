#include "simulation/truth/lit_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/scene/noise.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kLampGrid = 4;     // Shadow rays per side of an area light.
constexpr int kGatherRays = 48;  // Rays per vertex.

// The share of a lamp's power that arrives at a surface. A lamp emits most of its light forward,
// and a little sideways and backward.
float falloff(const AreaLight& light, const Vector3f& position, const Vector3f& normal,
              const Vector3f& from) {
  const Vector3f to = from - position;
  const float square = std::max(to.squaredNorm(), 0.04f);
  const Vector3f direction = to / std::sqrt(square);
  const float facing = normal.dot(direction), shining = 0.35f - 0.65f * light.front().dot(direction);
  return facing > 0 && shining > 0 ? facing * shining / square : 0.0f;
}

Vector3f direct_light(const AreaLight& light, const RayScene& tracer, const Vector3f& position,
                      const Vector3f& normal) {
  const Vector3f start = position + 0.004f * normal;
  float arriving = 0;
  for (int j = 0; j < kLampGrid; ++j) {
    for (int i = 0; i < kLampGrid; ++i) {
      const float u = (static_cast<float>(2 * i + 1) / kLampGrid) - 1,
                  v = (static_cast<float>(2 * j + 1) / kLampGrid) - 1;
      const Vector3f from = light.center + u * light.half_u + v * light.half_v;
      const float share = falloff(light, position, normal, from);
      if (share > 0 && !tracer.is_blocked(start, from - start, 0, 0.999f)) arriving += share;
    }
  }
  return light.power * (arriving / (kLampGrid * kLampGrid));
}

// Directions on the hemisphere around `normal`. Vertices with the same normal use the same
// directions, so that sampling errors look like a tint and not like grain.
Vector3f gather_direction(const Vector3f& normal, int index) {
  constexpr float kGolden = 0.61803399f;
  const float angle = 2 * std::numbers::pi_v<float> * kGolden * static_cast<float>(index);
  const float square = (static_cast<float>(index) + 0.5f) / kGatherRays;
  const float radius = std::sqrt(square);
  const Vector3f side = normal.unitOrthogonal();
  return side * (radius * std::cos(angle)) + normal.cross(side) * (radius * std::sin(angle)) +
         normal * std::sqrt(1 - square);
}

Vector3f mean_color(const Material& material) {
  Vector3f sum = Vector3f::Zero();
  for (std::uint32_t i = 0; i < 64; ++i)
    sum += albedo(material, {unit(mix(2 * i + 1)), unit(mix(2 * i + 2))});
  return sum / 64;
}

BakedLight bake_light(const Scene& scene, const RayScene& tracer) {
  std::vector<Vector3f> colors;
  for (const Material& material : scene.materials) colors.push_back(mean_color(material));

  BakedLight baked;
  baked.vertices.resize(scene.meshes.size());
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    for (const Vertex& vertex : scene.meshes[m].vertices) {
      Light light;
      for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        (i == 0 ? light.lamp : light.rest) +=
            direct_light(scene.lights[i], tracer, vertex.position, vertex.normal);
      }
      baked.vertices[m].push_back(light);
    }
  }

  std::vector<std::vector<Vector3f>> reflected(scene.meshes.size());
  std::vector<Ray> rays(kGatherRays);
  std::size_t count = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    for (const Vertex& vertex : scene.meshes[m].vertices) {
      for (int i = 0; i < kGatherRays; ++i) {
        rays[static_cast<std::size_t>(i)] =
            Ray{vertex.position + 0.004f * vertex.normal, gather_direction(vertex.normal, i)};
      }
      tracer.trace(rays);
      Vector3f sum = Vector3f::Zero();
      for (const Ray& ray : rays) {
        if (ray.mesh < 0) {
          sum += scene.ambient;
          continue;
        }
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(ray.mesh)];
        const Light& there =
            baked.vertices[static_cast<std::size_t>(ray.mesh)][mesh.triangles[ray.triangle][0]];
        sum += colors[static_cast<std::size_t>(mesh.material)].cwiseProduct(there.lamp + there.rest +
                                                                            scene.ambient * 2);
      }
      reflected[m].push_back(sum / kGatherRays);
      baked.reflected_mean += reflected[m].back();
      ++count;
    }
  }
  if (count > 0) baked.reflected_mean /= static_cast<float>(count);
  for (std::size_t m = 0; m < reflected.size(); ++m) {
    for (std::size_t i = 0; i < reflected[m].size(); ++i) baked.vertices[m][i].rest += reflected[m][i];
  }
  return baked;
}

}  // namespace

Result<LitScene> LitScene::of_world(std::string_view name) {
  auto scene = make_scene(name);
  if (!scene) return fail(scene.error());
  return make(std::move(*scene));
}

Result<LitScene> LitScene::make(Scene scene) {
  LitScene made;
  made.scene_ = std::move(scene);
  auto background = RayScene::make(made.scene_.meshes);
  if (!background) return fail(background.error());
  made.background_ = std::make_shared<RayScene>(std::move(*background));
  auto parts = PosedScene::Parts::make(made.scene_.figure.parts);
  if (!parts) return fail(parts.error());
  made.figure_parts_ = std::make_shared<PosedScene::Parts>(std::move(*parts));
  made.light_ = bake_light(made.scene_, *made.background_);
  return made;
}

}  // namespace copresence::simulation
