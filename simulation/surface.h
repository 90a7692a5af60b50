#pragma once

// What lies where a ray ended on a mesh.
//
// Thread: pure.

#include <Eigen/Core>

#include "simulation/mesh.h"
#include "simulation/ray_scene.h"

namespace copresence::simulation {

/// Between the values at the corners of the triangle that was hit.
template <class Value>
Value interpolate(const Ray& ray, const Value& a, const Value& b, const Value& c) {
  return a * (1 - ray.u - ray.v) + b * ray.u + c * ray.v;
}

struct Surface {
  Eigen::Vector3f position, normal;  ///< in the mesh's frame
  Eigen::Vector2f uv;
};

inline Surface surface_at(const Mesh& mesh, const Ray& ray) {
  const auto& t = mesh.triangles[ray.triangle];
  const Vertex &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  return {interpolate(ray, a.position, b.position, c.position),
          interpolate(ray, a.normal, b.normal, c.normal).normalized(), interpolate(ray, a.uv, b.uv, c.uv)};
}

}  // namespace copresence::simulation
