#include "simulation/light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "simulation/hash_noise.h"

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr int kLampGrid = 4;     // shadow rays per side of an area light
constexpr int kGatherRays = 48;  // per vertex

Vector3f front_of(const AreaLight& light) {
  return light.half_v.cross(light.half_u).normalized();
}

// Share of a lamp's power that arrives: a lamp shines forward most, a little sideways and back as a globe
// does.
float falloff(const AreaLight& light, const Vector3f& position, const Vector3f& normal,
              const Vector3f& from) {
  const Vector3f to = from - position;
  const float square = std::max(to.squaredNorm(), 0.04f);
  const Vector3f direction = to / std::sqrt(square);
  const float facing = normal.dot(direction), shining = 0.35f - 0.65f * front_of(light).dot(direction);
  return facing > 0 && shining > 0 ? facing * shining / square : 0.0f;
}

// The same from a lamp's middle, at many places.
void falloff(const AreaLight& light, const MovingPoints& points, std::span<float> shares) {
  const Vector3f front = front_of(light);
  const float lx = light.center.x(), ly = light.center.y(), lz = light.center.z();
  const float fx = front.x(), fy = front.y(), fz = front.z();
  const float* __restrict px = points.places.x.data();
  const float* __restrict py = points.places.y.data();
  const float* __restrict pz = points.places.z.data();
  const float* __restrict nx = points.normal_x.data();
  const float* __restrict ny = points.normal_y.data();
  const float* __restrict nz = points.normal_z.data();
  float* __restrict share = shares.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const float tx = lx - px[i], ty = ly - py[i], tz = lz - pz[i];
    const float square = std::max(tx * tx + (ty * ty + tz * tz), 0.04f), root = std::sqrt(square);
    const float dx = tx / root, dy = ty / root, dz = tz / root;
    const float facing = nx[i] * dx + (ny[i] * dy + nz[i] * dz);
    const float shining = 0.35f - 0.65f * (fx * dx + (fy * dy + fz * dz));
    share[i] = (facing > 0) & (shining > 0) ? facing * shining / square : 0.0f;
  }
}

Vector3f direct(const AreaLight& light, const RayScene& scene, const Vector3f& position,
                const Vector3f& normal) {
  const Vector3f start = position + 0.004f * normal;
  float arriving = 0;
  for (int j = 0; j < kLampGrid; ++j) {
    for (int i = 0; i < kLampGrid; ++i) {
      const float u = (static_cast<float>(2 * i + 1) / kLampGrid) - 1,
                  v = (static_cast<float>(2 * j + 1) / kLampGrid) - 1;
      const Vector3f from = light.center + u * light.half_u + v * light.half_v;
      const float share = falloff(light, position, normal, from);
      if (share > 0 && !scene.is_blocked(start, from - start, 0, 0.999f)) arriving += share;
    }
  }
  return light.power * (arriving / (kLampGrid * kLampGrid));
}

// The same directions over the hemisphere for every vertex of one normal: errors show as a tint, never as
// grain.
Vector3f gather_direction(const Vector3f& normal, int index) {
  constexpr float kGolden = 0.61803399f;
  const float turn = 2 * std::numbers::pi_v<float> * kGolden * static_cast<float>(index);
  const float square = (static_cast<float>(index) + 0.5f) / kGatherRays;
  const float radius = std::sqrt(square);
  const Vector3f side = normal.unitOrthogonal();
  return side * (radius * std::cos(turn)) + normal.cross(side) * (radius * std::sin(turn)) +
         normal * std::sqrt(1 - square);
}

Vector3f mean_color(const Material& material) {
  Vector3f sum = Vector3f::Zero();
  for (std::uint32_t i = 0; i < 64; ++i)
    sum += albedo(material, {unit(mix(2 * i + 1)), unit(mix(2 * i + 2))});
  return sum / 64;
}

}  // namespace

BakedLight bake_light(const Furnishing& world, const RayScene& scene) {
  std::vector<Vector3f> colors;
  for (const Material& material : world.materials) colors.push_back(mean_color(material));

  BakedLight baked;
  baked.vertices.resize(world.meshes.size());
  for (std::size_t m = 0; m < world.meshes.size(); ++m) {
    for (const Vertex& vertex : world.meshes[m].vertices) {
      Light light;
      for (std::size_t i = 0; i < world.lights.size(); ++i) {
        (i == 0 ? light.lamp : light.rest) += direct(world.lights[i], scene, vertex.position, vertex.normal);
      }
      baked.vertices[m].push_back(light);
    }
  }

  std::vector<std::vector<Vector3f>> reflected(world.meshes.size());
  std::vector<Ray> rays(kGatherRays);
  std::size_t count = 0;
  for (std::size_t m = 0; m < world.meshes.size(); ++m) {
    for (const Vertex& vertex : world.meshes[m].vertices) {
      for (int i = 0; i < kGatherRays; ++i) {
        rays[static_cast<std::size_t>(i)] =
            Ray{vertex.position + 0.004f * vertex.normal, gather_direction(vertex.normal, i)};
      }
      scene.trace(rays);
      Vector3f sum = Vector3f::Zero();
      for (const Ray& ray : rays) {
        if (ray.mesh < 0) {
          sum += world.ambient;
          continue;
        }
        const Mesh& mesh = world.meshes[static_cast<std::size_t>(ray.mesh)];
        const Light& there =
            baked.vertices[static_cast<std::size_t>(ray.mesh)][mesh.triangles[ray.triangle][0]];
        sum += colors[static_cast<std::size_t>(mesh.material)].cwiseProduct(there.lamp + there.rest +
                                                                            world.ambient * 2);
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

void MovingPoints::resize(std::size_t count) {
  places.resize(count);
  for (auto* values : {&normal_x, &normal_y, &normal_z}) values->resize(count);
}

void light_at(const Furnishing& world, const BakedLight& baked, const MovingPoints& points,
              MovingLight& light) {
  const std::size_t n = points.places.size();
  const float* __restrict normal_y = points.normal_y.data();
  std::vector<float> shares(n);
  for (std::size_t c = 0; c < 3; ++c) {
    light.lamp[c].assign(n, 0.0f);
    light.rest[c].assign(n, 0.0f);
  }
  for (std::size_t k = 0; k < world.lights.size(); ++k) {
    falloff(world.lights[k], points, shares);
    for (std::size_t c = 0; c < 3; ++c) {
      float* __restrict sum = (k == 0 ? light.lamp : light.rest)[c].data();
      const float* __restrict share = shares.data();
      const float power = world.lights[k].power[static_cast<Eigen::Index>(c)];
      for (std::size_t i = 0; i < n; ++i) sum[i] += power * share[i];
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    float* __restrict sum = light.rest[c].data();
    const float reflected = baked.reflected_mean[static_cast<Eigen::Index>(c)];
    for (std::size_t i = 0; i < n; ++i) sum[i] += reflected * (1.0f - 0.25f * normal_y[i]);
  }
}

}  // namespace copresence::simulation
