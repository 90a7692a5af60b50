#pragma once

// Triangle meshes, and the simple solids that form furniture and people.
//
// Units are metres. The world frame is x right, y down, z forward, with the floor at y = 0. So
// objects on the floor have negative y. Light is stored per vertex, so faces are divided into cells
// of up to `cell` metres.
//
// Thread: one thread at a time per object.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace copresence::simulation {

struct Vertex {
  Eigen::Vector3f position, normal;  ///< The normal points out of the solid, length 1.
  Eigen::Vector2f uv;                ///< Texture coordinates, mostly metres along the surface.
};

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  int material = 0;  ///< Index into Scene::materials.
};

/// A flat rectangle: `center` +- `half_u` +- `half_v`. Seen from its front, u points right and v
/// points down. Texture coordinates are metres from the corner (-half_u, -half_v). If `whole` is
/// true, texture coordinates run from 0 to 1 instead.
Mesh panel(const Eigen::Vector3f& center, const Eigen::Vector3f& half_u, const Eigen::Vector3f& half_v,
           int material, float cell, bool whole = false);

/// A box of the given full size, rotated about the vertical by `yaw` radians.
Mesh box(const Eigen::Vector3f& center, const Eigen::Vector3f& size, int material, float yaw = 0,
         float cell = 0.08f);

/// A cross-section of a loft: an ellipse around (x, z) at height y, in the frame of the loft.
struct Ring {
  float y = 0, half_x = 0, half_z = 0, x = 0, z = 0;
};

/// A closed body, interpolated through cross-sections. Requires two or more rings in ascending
/// order of y. Texture coordinates are distances in metres around and along the body. `square`
/// shapes the cross-section: 0 gives an ellipse, 1 nearly a rectangle. `pose` is mesh_from_loft.
Mesh loft(const Eigen::Isometry3f& pose, std::span<const Ring> rings, int material, float square = 0,
          int around = 24, int steps_per_ring = 4);

/// A surface given by a function of (u, v), both from 0 to 1. Both sides are visible. Texture
/// coordinates run from 0 to `metres_u` and `metres_v`.
template <class Surface>
Mesh sheet(int cells_u, int cells_v, float metres_u, float metres_v, int material, Surface&& surface);

/// Sets each vertex normal to the area-weighted mean of its triangles' normals. Vertices without a
/// triangle keep their normals.
void smooth_normals(Mesh& mesh);

template <class Surface>
Mesh sheet(int cells_u, int cells_v, float metres_u, float metres_v, int material, Surface&& surface) {
  Mesh mesh;
  mesh.material = material;
  for (int j = 0; j <= cells_v; ++j) {
    for (int i = 0; i <= cells_u; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(cells_u);
      const float v = static_cast<float>(j) / static_cast<float>(cells_v);
      mesh.vertices.push_back({surface(u, v), Eigen::Vector3f::Zero(), {u * metres_u, v * metres_v}});
    }
  }
  const auto columns = static_cast<std::uint32_t>(cells_u + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(cells_v); ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      const std::uint32_t a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  smooth_normals(mesh);
  return mesh;
}

}  // namespace copresence::simulation
