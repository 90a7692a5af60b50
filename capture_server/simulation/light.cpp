#include "capture_server/simulation/light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "capture_server/simulation/hash_noise.h"

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

Light light_at(const Furnishing& world, const BakedLight& baked, const Vector3f& position,
               const Vector3f& normal) {
  Light light;
  for (std::size_t i = 0; i < world.lights.size(); ++i) {
    const AreaLight& lamp = world.lights[i];
    (i == 0 ? light.lamp : light.rest) += lamp.power * falloff(lamp, position, normal, lamp.center);
  }
  light.rest += baked.reflected_mean * (1.0f - 0.25f * normal.y());
  return light;
}

void ShadowPoints::add(const Vector3f& position, const Vector3f& lamp) {
  const Vector3f to = lamp - position;
  const float length = to.norm();
  x.push_back(position.x());
  y.push_back(position.y());
  z.push_back(position.z());
  to_x.push_back(to.x() / length);
  to_y.push_back(to.y() / length);
  to_z.push_back(to.z() / length);
  distance.push_back(length);
}

// The closest approach of the way to the lamp and the capsule's axis decides: the lamp's disc seen past an
// edge.
void shade(const ShadowPoints& points, std::span<const Capsule> capsules, float lamp_radius,
           std::span<float> hidden) {
  assert(hidden.size() == points.size());
  const std::size_t n = points.size();
  const float* __restrict px = points.x.data();
  const float* __restrict py = points.y.data();
  const float* __restrict pz = points.z.data();
  const float* __restrict lx = points.to_x.data();
  const float* __restrict ly = points.to_y.data();
  const float* __restrict lz = points.to_z.data();
  const float* __restrict far = points.distance.data();
  float* __restrict out = hidden.data();
  std::fill(hidden.begin(), hidden.end(), 0.0f);
  for (const Capsule& capsule : capsules) {
    const Vector3f axis = capsule.to - capsule.from;
    const float ax = capsule.from.x(), ay = capsule.from.y(), az = capsule.from.z();
    const float ex = axis.x(), ey = axis.y(), ez = axis.z(), radius = capsule.radius;
    const float square = std::max(axis.squaredNorm(), 1e-8f);
    for (std::size_t i = 0; i < n; ++i) {
      const float wx = px[i] - ax, wy = py[i] - ay, wz = pz[i] - az;
      const float along = lx[i] * ex + ly[i] * ey + lz[i] * ez;
      const float ray_w = lx[i] * wx + ly[i] * wy + lz[i] * wz, axis_w = ex * wx + ey * wy + ez * wz;
      float s = (axis_w - along * ray_w) / std::max(square - along * along, 1e-6f * square);
      s = std::min(std::max(s, 0.0f), 1.0f);
      const float t = std::min(std::max(s * along - ray_w, 0.0f), far[i]);
      const float dx = wx + t * lx[i] - s * ex, dy = wy + t * ly[i] - s * ey, dz = wz + t * lz[i] - s * ez;
      const float gap = std::sqrt(dx * dx + dy * dy + dz * dz) - radius;
      const float penumbra = lamp_radius * t / far[i] + 0.004f;
      float cover = 0.5f - 0.5f * gap / penumbra;
      cover = std::min(std::max(cover, 0.0f), 1.0f);
      cover = cover * cover * (3 - 2 * cover);
      cover = t > 0.02f ? cover : 0.0f;  // a point does not shade itself
      out[i] = out[i] + cover - out[i] * cover;
    }
  }
}

}  // namespace copresence::simulation
