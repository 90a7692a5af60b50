#include "simulation/scene/mesh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

void append(Mesh& mesh, const Mesh& more) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles)
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

// Catmull-Rom interpolation between b and c.
float spline(float a, float b, float c, float d, float t) {
  return b + 0.5f * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

Ring between(std::span<const Ring> rings, std::size_t i, float t) {
  const Ring& b = rings[i];
  const Ring& c = rings[i + 1];
  const Ring& a = rings[i == 0 ? 0 : i - 1];
  const Ring& d = rings[std::min(i + 2, rings.size() - 1)];
  const auto at = [&](float Ring::*member) { return spline(a.*member, b.*member, c.*member, d.*member, t); };
  return {b.y + (c.y - b.y) * t, std::max(at(&Ring::half_x), 1e-4f), std::max(at(&Ring::half_z), 1e-4f),
          at(&Ring::x), at(&Ring::z)};
}

}  // namespace

Mesh panel(const Vector3f& center, const Vector3f& half_u, const Vector3f& half_v, int material, float cell,
           bool whole) {
  const float width = 2 * half_u.norm(), height = 2 * half_v.norm();
  const int cells_u = std::max(1, static_cast<int>(std::ceil(width / cell)));
  const int cells_v = std::max(1, static_cast<int>(std::ceil(height / cell)));
  Mesh mesh = sheet(
      cells_u, cells_v, whole ? 1 : width, whole ? 1 : height, material,
      [&](float u, float v) -> Vector3f { return center + half_u * (2 * u - 1) + half_v * (2 * v - 1); });
  const Vector3f normal = half_v.cross(half_u).normalized();
  for (Vertex& vertex : mesh.vertices) vertex.normal = normal;
  return mesh;
}

Mesh box(const Vector3f& center, const Vector3f& size, int material, float yaw, float cell) {
  const Eigen::Matrix3f rotation = Eigen::AngleAxisf(yaw, Vector3f::UnitY()).toRotationMatrix();
  const Vector3f x = rotation * Vector3f(size.x() / 2, 0, 0), y(0, size.y() / 2, 0),
                 z = rotation * Vector3f(0, 0, size.z() / 2);
  const std::array<std::array<Vector3f, 3>, 6> faces{
      {{-z, -x, y}, {z, x, y}, {-x, z, y}, {x, -z, y}, {-y, x, z}, {y, x, -z}}};
  Mesh mesh;
  mesh.material = material;
  for (const auto& [out, u, v] : faces) {
    const bool outwards = v.cross(u).dot(out) > 0;
    append(mesh, panel(center + out, outwards ? u : Vector3f(-u), v, material, cell));
  }
  return mesh;
}

Mesh loft(const Eigen::Isometry3f& pose, std::span<const Ring> rings, int material, float square, int around,
          int steps_per_ring) {
  assert(rings.size() >= 2 && around >= 3 && steps_per_ring >= 1);
  Mesh mesh;
  mesh.material = material;
  const float exponent = 1 - 0.7f * square;
  const int steps = static_cast<int>(rings.size() - 1) * steps_per_ring;
  for (int j = 0; j <= steps; ++j) {
    const int segment = std::min(j / steps_per_ring, static_cast<int>(rings.size()) - 2);
    const float t = static_cast<float>(j - segment * steps_per_ring) / static_cast<float>(steps_per_ring);
    const Ring ring = between(rings, static_cast<std::size_t>(segment), t);
    for (int i = 0; i <= around; ++i) {
      const float angle =
          2 * std::numbers::pi_v<float> * static_cast<float>(i % around) / static_cast<float>(around);
      const auto bulge = [&](float x) { return std::copysign(std::pow(std::abs(x), exponent), x); };
      const Vector3f local(ring.x + ring.half_x * bulge(std::cos(angle)), ring.y,
                           ring.z + ring.half_z * bulge(std::sin(angle)));
      const float share = static_cast<float>(i) / static_cast<float>(around);
      const float girth =
          std::numbers::pi_v<float> * (rings[rings.size() / 2].half_x + rings[rings.size() / 2].half_z);
      mesh.vertices.push_back({pose * local, Vector3f::Zero(), {share * girth, ring.y}});
    }
  }
  const auto columns = static_cast<std::uint32_t>(around + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(steps); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(around); ++i) {
      const std::uint32_t a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
  }
  for (const bool end : {false, true}) {
    const Ring& ring = end ? rings.back() : rings.front();
    const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({pose * Vector3f(ring.x, ring.y, ring.z), Vector3f::Zero(), {0, ring.y}});
    const std::uint32_t first = end ? static_cast<std::uint32_t>(steps) * columns : 0;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(around); ++i) {
      if (end) {
        mesh.triangles.push_back({tip, first + i + 1, first + i});
      } else {
        mesh.triangles.push_back({tip, first + i, first + i + 1});
      }
    }
  }
  smooth_normals(mesh);
  // On a closed surface, the first and the last column of vertices are the same line.
  for (std::uint32_t j = 0; j <= static_cast<std::uint32_t>(steps); ++j) {
    Vertex& left = mesh.vertices[j * columns];
    Vertex& right = mesh.vertices[j * columns + columns - 1];
    left.normal = right.normal = (left.normal + right.normal).normalized();
  }
  return mesh;
}

void smooth_normals(Mesh& mesh) {
  std::vector<Vector3f> sums(mesh.vertices.size(), Vector3f::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3f& a = mesh.vertices[t[0]].position;
    const Vector3f normal = (mesh.vertices[t[1]].position - a).cross(mesh.vertices[t[2]].position - a);
    for (const std::uint32_t i : t) sums[i] += normal;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].squaredNorm() > 0) mesh.vertices[i].normal = sums[i].normalized();
  }
}

}  // namespace copresence::simulation
