#include "simulation/figure_surface.h"

#include <cmath>

namespace copresence::simulation {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// How the pattern changes over `distance` pixels of the picture's buffer, as far as a neighbour shows the same part.
Vector2f change_over(const FigureHits& hits, const PatternImage& pattern, std::size_t pixel,
                     std::size_t distance) {
  constexpr float kSeam = 0.05f;  // metres; more is the jump from one end of the cloth to the other
  const std::size_t next = pixel + distance;
  if (next < pattern.size() && hits.part_of[next] == hits.part_of[pixel]) {
    const Vector2f change = pattern[next] - pattern[pixel];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  if (pixel >= distance && hits.part_of[pixel - distance] == hits.part_of[pixel]) {
    const Vector2f change = pattern[pixel] - pattern[pixel - distance];
    if (change.squaredNorm() < kSeam * kSeam) return change;
  }
  return Vector2f::Zero();
}

}  // namespace

void find_surface(const Mesh& part, const Eigen::Isometry3f& world_from_part, const Sight& sight,
                  std::span<const Hit> hits, PartSurface& surface) {
  const std::size_t n = hits.size();
  surface.points.resize(n);
  surface.facing.resize(n);
  float* __restrict px = surface.points.places.x.data();
  float* __restrict py = surface.points.places.y.data();
  float* __restrict pz = surface.points.places.z.data();
  float* __restrict nx = surface.points.normal_x.data();
  float* __restrict ny = surface.points.normal_y.data();
  float* __restrict nz = surface.points.normal_z.data();
  float* __restrict facing = surface.facing.data();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& t = part.triangles[hits[i].triangle];
    const Vector3f normal = part.vertices[t[0]].normal * (1 - hits[i].u - hits[i].v) +
                            part.vertices[t[1]].normal * hits[i].u + part.vertices[t[2]].normal * hits[i].v;
    nx[i] = normal.x();
    ny[i] = normal.y();
    nz[i] = normal.z();
    const Vector3f& direction = sight.directions[hits[i].pixel];
    px[i] = direction.x();
    py[i] = direction.y();
    pz[i] = direction.z();
    facing[i] = hits[i].far;  // for now
  }
  const Eigen::Matrix3f turn = world_from_part.linear();
  const Vector3f eye = sight.eye;
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const float length = std::sqrt(nx[i] * nx[i] + (ny[i] * ny[i] + nz[i] * nz[i]));
    const float x = nx[i] / length, y = ny[i] / length, z = nz[i] / length;
    const float wx = turn(0, 0) * x + (turn(0, 1) * y + turn(0, 2) * z);
    const float wy = turn(1, 0) * x + (turn(1, 1) * y + turn(1, 2) * z);
    const float wz = turn(2, 0) * x + (turn(2, 1) * y + turn(2, 2) * z);
    const float dx = px[i], dy = py[i], dz = pz[i], far = facing[i];
    const float cosine = (wx * dx + (wy * dy + wz * dz)) / std::sqrt(dx * dx + (dy * dy + dz * dz));
    const float side = cosine > 0 ? -1.0f : 1.0f;
    nx[i] = side * wx;
    ny[i] = side * wy;
    nz[i] = side * wz;
    facing[i] = std::abs(cosine);
    px[i] = eye.x() + far * dx;
    py[i] = eye.y() + far * dy;
    pz[i] = eye.z() + far * dz;
  }
}

void find_pattern(const Mesh& part, std::span<const Hit> hits, PatternImage& pattern) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto& t = part.triangles[hits[i].triangle];
    pattern[hits[i].pixel] = part.vertices[t[0]].uv * (1 - hits[i].u - hits[i].v) +
                             part.vertices[t[1]].uv * hits[i].u + part.vertices[t[2]].uv * hits[i].v;
  }
}

void spread_looks(const FigureHits& all, std::span<const Hit> hits, const PatternImage& pattern,
                  std::vector<float>& u, std::vector<float>& v) {
  const std::size_t n = hits.size();
  u.resize(n * kFigureLooks.size());
  v.resize(u.size());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t pixel = hits[i].pixel;
    const Vector2f across = change_over(all, pattern, pixel, 1),
                   down = change_over(all, pattern, pixel, all.width);
    for (std::size_t look = 0; look < kFigureLooks.size(); ++look) {
      const Vector2f place = pattern[pixel] + kFigureLooks[look].x() * across + kFigureLooks[look].y() * down;
      u[look * n + i] = place.x();
      v[look * n + i] = place.y();
    }
  }
}

}  // namespace copresence::simulation
