#include "tools/calibrate/alignment/surface.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/frame/depth_unit.h"

namespace copresence::alignment {
namespace {

constexpr float kSteps = 351.3f;  // metres: a depth z is kSteps / z sensor steps
constexpr int kRadius = 6;        // pixels: the window is 13 by 13, every other pixel of it
constexpr int kSamples = (kRadius + 1) * (kRadius + 1);
constexpr int kFewest = kSamples / 2;
constexpr float kGrazing =
    0.15f;  // cosine between normal and ray below which a Kinect's depth is worth nothing

struct Plane {
  float along_x = 0, along_y = 0, here = 0;  // steps: steps(dx, dy) = along_x dx + along_y dy + here
};

struct Sample {
  float dx, dy, steps;
};

// Least squares over the samples that lie within `tolerance(sample)` of `expected(sample)`.
template <class Expected, class Tolerance>
bool fit(const std::vector<Sample>& samples, Expected&& expected, Tolerance&& tolerance, Plane& plane) {
  float n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, s = 0, sx = 0, sy = 0;
  for (const Sample& sample : samples) {
    if (std::abs(sample.steps - expected(sample)) > tolerance(sample)) continue;
    n += 1;
    x += sample.dx;
    y += sample.dy;
    xx += sample.dx * sample.dx;
    xy += sample.dx * sample.dy;
    yy += sample.dy * sample.dy;
    s += sample.steps;
    sx += sample.steps * sample.dx;
    sy += sample.steps * sample.dy;
  }
  if (n < kFewest) return false;
  Eigen::Matrix3f A;
  A << xx, xy, x, xy, yy, y, x, y, n;
  if (std::abs(A.determinant()) < 1e-3f * n) return false;
  const Eigen::Vector3f solution = A.inverse() * Eigen::Vector3f(sx, sy, s);
  plane = {solution.x(), solution.y(), solution.z()};
  return true;
}

// Error of a point along its normal: of depth, and of where on a slanted surface depth was taken.
// Source: Khoshelham and Elberink 2012 (depth), Nguyen, Izadi and Lovell 2012 (lateral).
float sigma_along_normal(float z, float cosine, double fx) {
  const float theta = std::acos(std::clamp(cosine, 0.0f, 1.0f));
  const float sine = std::sin(theta);
  const auto right_angle = static_cast<float>(std::numbers::pi / 2);
  const float lateral_px = 0.8f + 0.035f * theta / std::max(right_angle - theta, 0.1f);
  const float lateral = lateral_px * z / static_cast<float>(fx) * sine;
  const float axial = static_cast<float>(sensor_sigma_m(z)) * cosine;
  return std::sqrt(axial * axial + lateral * lateral);
}

}  // namespace

Surface make_surface(const Image<float>& depth_m, const CameraModel& model, float near_m, float far_m) {
  const int width = depth_m.width(), height = depth_m.height();
  assert(width == model.width && height == model.height);
  Surface surface{model,
                  Image<float>(width, height),
                  Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero()),
                  Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero()),
                  Image<float>(width, height),
                  0,
                  0};
  Image<float> steps(width, height);
  for (std::size_t i = 0; i < depth_m.pixels().size(); ++i) {
    const float z = depth_m.data()[i];
    if (!(z >= near_m && z <= far_m)) continue;
    surface.depth_m.data()[i] = z;
    steps.data()[i] = kSteps / z;
    ++surface.measured;
  }
  const std::vector<Eigen::Vector2f> ray = rays(model);
  const auto ray_at = [&](int x, int y) {
    const Eigen::Vector2f& r = ray[static_cast<std::size_t>(y) * width + x];
    return Eigen::Vector3f(r.x(), r.y(), 1);
  };
  std::vector<Sample> samples;
  for (int y = kRadius; y < height - kRadius; ++y) {
    for (int x = kRadius; x < width - kRadius; ++x) {
      const float center = steps(x, y);
      if (center == 0) continue;
      samples.clear();
      for (int dy = -kRadius; dy <= kRadius; dy += 2) {
        for (int dx = -kRadius; dx <= kRadius; dx += 2) {
          const float s = steps(x + dx, y + dy);
          if (s > 0) samples.push_back({static_cast<float>(dx), static_cast<float>(dy), s});
        }
      }
      if (static_cast<int>(samples.size()) < kFewest) continue;
      Plane plane;
      const auto reach = [](const Sample& s) { return 3 + 0.9f * std::max(std::abs(s.dx), std::abs(s.dy)); };
      if (!fit(
              samples, [center](const Sample&) { return center; }, reach, plane))
        continue;
      const Plane first = plane;
      const auto on_first = [&first](const Sample& s) {
        return first.along_x * s.dx + first.along_y * s.dy + first.here;
      };
      if (!fit(
              samples, on_first, [](const Sample&) { return 2.0f; }, plane))
        continue;
      if (std::abs(plane.here - center) > 2 || plane.here <= 1) continue;
      const float z = kSteps / plane.here;
      const Eigen::Vector3f r = ray_at(x, y);
      const Eigen::Vector3f ray_x = 0.5f * (ray_at(x + 1, y) - ray_at(x - 1, y));
      const Eigen::Vector3f ray_y = 0.5f * (ray_at(x, y + 1) - ray_at(x, y - 1));
      const float z_x = -z * z / kSteps * plane.along_x, z_y = -z * z / kSteps * plane.along_y;
      // Tangents of the surface (ray * z) along the picture's rows and columns.
      const Eigen::Vector3f normal = (ray_y * z + r * z_y).cross(ray_x * z + r * z_x).normalized();
      const float cosine = -normal.dot(r) / r.norm();
      if (cosine < kGrazing) continue;
      surface.point(x, y) = r * z;
      surface.normal(x, y) = normal;
      surface.sigma(x, y) = sigma_along_normal(z, cosine, model.fx);
      ++surface.planar;
    }
  }
  return surface;
}

}  // namespace copresence::alignment
