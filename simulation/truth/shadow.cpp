#include "simulation/truth/shadow.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace copresence::simulation {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kLeastGroup = 64;  // Smallest number of points with a capsule list of their own.
constexpr std::size_t kGroups = 8;       // Number of groups into which a larger group is divided.
constexpr float kSharpest = 0.004f;      // Half the width of the penumbra at the capsule itself, in metres.

struct Range {
  std::size_t first = 0, end = 0;
};

// Returns the distance between the segment from `point` to `lamp` and the axis of a capsule.
float least_distance(const Vector3f& point, const Vector3f& lamp, const Capsule& capsule) {
  // Source: Ericson, Real-Time Collision Detection, section 5.1.9 (closest points of two segments).
  const Vector3f to_lamp = lamp - point, axis = capsule.to - capsule.from, between = point - capsule.from;
  const float a = to_lamp.squaredNorm(), e = std::max(axis.squaredNorm(), 1e-8f), f = axis.dot(between);
  const float c = to_lamp.dot(between), b = to_lamp.dot(axis);
  const float determinant = a * e - b * b;
  float s = determinant > 1e-6f * a * e ? std::clamp((b * f - c * e) / determinant, 0.0f, 1.0f) : 0.0f;
  float t = (b * s + f) / e;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0f, 1.0f);
    s = std::clamp((b * t - c) / a, 0.0f, 1.0f);
  }
  return (between + to_lamp * s - axis * t).norm();
}

// True if the capsule may hide part of the lamp from any point within `radius` of `middle`.
bool may_shade(const Capsule& capsule, const Vector3f& middle, float radius, const Vector3f& lamp,
               float lamp_radius) {
  constexpr float kRounding = 1e-3f;  // In metres.
  const float nearest_lamp = (lamp - middle).norm() - radius;
  if (nearest_lamp <= 0.1f) return true;
  const float farthest =
      std::max((capsule.from - middle).norm(), (capsule.to - middle).norm()) + radius + kRounding;
  const float penumbra = lamp_radius * std::min(farthest / nearest_lamp, 1.0f) + kSharpest;
  return least_distance(middle, lamp, capsule) < capsule.radius + penumbra + radius + kRounding;
}

// Adds the shadow of one capsule. The hidden share of the lamp depends on the smallest distance
// between the ray to the lamp and the axis of the capsule.
void add_shadow(const ShadowPoints& points, const Range& range, const Capsule& capsule, float lamp_radius,
                float* __restrict hidden) {
  const float* __restrict px = points.x.data();
  const float* __restrict py = points.y.data();
  const float* __restrict pz = points.z.data();
  const float* __restrict lx = points.to_x.data();
  const float* __restrict ly = points.to_y.data();
  const float* __restrict lz = points.to_z.data();
  const float* __restrict far = points.distance.data();
  const Vector3f axis = capsule.to - capsule.from;
  const float ax = capsule.from.x(), ay = capsule.from.y(), az = capsule.from.z();
  const float ex = axis.x(), ey = axis.y(), ez = axis.z(), radius = capsule.radius;
  const float square = std::max(axis.squaredNorm(), 1e-8f);
#pragma GCC ivdep
  for (std::size_t i = range.first; i < range.end; ++i) {
    const float wx = px[i] - ax, wy = py[i] - ay, wz = pz[i] - az;
    const float along = lx[i] * ex + ly[i] * ey + lz[i] * ez;
    const float ray_w = lx[i] * wx + ly[i] * wy + lz[i] * wz, axis_w = ex * wx + ey * wy + ez * wz;
    float s = (axis_w - along * ray_w) / std::max(square - along * along, 1e-6f * square);
    s = std::min(std::max(s, 0.0f), 1.0f);
    const float t = std::min(std::max(s * along - ray_w, 0.0f), far[i]);
    const float dx = wx + t * lx[i] - s * ex, dy = wy + t * ly[i] - s * ey, dz = wz + t * lz[i] - s * ez;
    const float gap = std::sqrt(dx * dx + dy * dy + dz * dz) - radius;
    const float penumbra = lamp_radius * t / far[i] + kSharpest;
    float cover = 0.5f - 0.5f * gap / penumbra;
    cover = std::min(std::max(cover, 0.0f), 1.0f);
    cover = cover * cover * (3 - 2 * cover);
    cover = t > 0.02f ? cover : 0.0f;  // A point on the capsule does not shade itself.
    hidden[i] = hidden[i] + cover - hidden[i] * cover;
  }
}

// Divides the points into smaller and smaller groups, and drops the capsules that cannot shade any
// point of a group. Dropping only saves time, because the dropped capsules would add no shadow.
void add_shadows(const ShadowPoints& points, const Range& range, std::span<const Capsule> capsules,
                 float lamp_radius, std::span<float> hidden) {
  const auto bounds = [&](const std::vector<float>& values) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(range.first);
    const auto [low, high] =
        std::minmax_element(first, values.begin() + static_cast<std::ptrdiff_t>(range.end));
    return std::pair(*low, *high);
  };
  const auto [low_x, high_x] = bounds(points.x);
  const auto [low_y, high_y] = bounds(points.y);
  const auto [low_z, high_z] = bounds(points.z);
  const Vector3f low(low_x, low_y, low_z), high(high_x, high_y, high_z);
  std::vector<Capsule> chosen;
  for (const Capsule& capsule : capsules) {
    if (may_shade(capsule, 0.5f * (low + high), 0.5f * (high - low).norm(), points.lamp, lamp_radius))
      chosen.push_back(capsule);
  }
  const std::size_t count = range.end - range.first;
  if (count <= kLeastGroup || chosen.size() < 2) {
    for (const Capsule& capsule : chosen) add_shadow(points, range, capsule, lamp_radius, hidden.data());
    return;
  }
  const std::size_t step = std::max(kLeastGroup, count / kGroups);
  for (std::size_t first = range.first; first < range.end; first += step)
    add_shadows(points, {first, std::min(first + step, range.end)}, chosen, lamp_radius, hidden);
}

}  // namespace

void ShadowPoints::resize(std::size_t count) {
  for (auto* values : {&x, &y, &z}) values->resize(count);
}

void ShadowPoints::add(const Vector3f& position) {
  x.push_back(position.x());
  y.push_back(position.y());
  z.push_back(position.z());
}

void ShadowPoints::aim_at(const Vector3f& lamp_center) {
  lamp = lamp_center;
  const std::size_t n = size();
  for (auto* values : {&to_x, &to_y, &to_z, &distance}) values->resize(n);
  const float lx = lamp.x(), ly = lamp.y(), lz = lamp.z();
  const float* __restrict px = x.data();
  const float* __restrict py = y.data();
  const float* __restrict pz = z.data();
  float* __restrict dx = to_x.data();
  float* __restrict dy = to_y.data();
  float* __restrict dz = to_z.data();
  float* __restrict far = distance.data();
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const float tx = lx - px[i], ty = ly - py[i], tz = lz - pz[i];
    const float length = std::sqrt(tx * tx + (ty * ty + tz * tz));
    dx[i] = tx / length;
    dy[i] = ty / length;
    dz[i] = tz / length;
    far[i] = length;
  }
}

void cast_shadows(const ShadowPoints& points, std::span<const Capsule> capsules, float lamp_radius,
                  std::span<float> hidden) {
  assert(hidden.size() == points.size() && points.distance.size() == points.size());
  std::fill(hidden.begin(), hidden.end(), 0.0f);
  if (points.size() > 0) add_shadows(points, {0, points.size()}, capsules, lamp_radius, hidden);
}

}  // namespace copresence::simulation
