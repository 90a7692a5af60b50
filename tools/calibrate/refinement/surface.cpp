#include "tools/calibrate/refinement/surface.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/frame/depth_unit.h"
#include "tools/calibrate/geometry/plane_depth.h"

namespace copresence::calibrate {
namespace {

// The disparity at depth z (metres) is kSteps / z disparity steps.
constexpr auto kSteps = static_cast<float>(kKinectV1Noise.disparity_constant_m);
// Radius of the window in pixels. The window uses every second column and row of 13 x 13 pixels.
constexpr int kRadius = 6;
constexpr int kSamples = (kRadius + 1) * (kRadius + 1);
constexpr int kFewest = kSamples / 2;
// Cosine between normal and ray below which a Kinect's depth is useless.
constexpr float kGrazing = 0.15f;

struct Plane {
  float along_x = 0, along_y = 0, here = 0;  // Disparity steps at (dx, dy): along_x dx + along_y dy + here.
  float at(float dx, float dy) const { return along_x * dx + along_y * dy + here; }
};

struct Sample {
  float dx, dy, steps;
};

// Least squares over the samples within `tolerance(sample)` of `expected(sample)`.
template <class Expected, class Tolerance>
bool fit(const std::vector<Sample>& samples, Expected&& expected, Tolerance&& tolerance, Plane& plane) {
  PlaneLeastSquares<float> sums;
  for (const Sample& sample : samples) {
    if (std::abs(sample.steps - expected(sample)) > tolerance(sample)) continue;
    sums.add(sample.dx, sample.dy, sample.steps);
  }
  Eigen::Vector3f fitted;
  if (sums.count() < kFewest || !sums.solve(1e-3f, fitted)) return false;
  plane = {fitted.x(), fitted.y(), fitted.z()};
  return true;
}

// Fits a quadratic surface to the samples near a plane. Uses the surface's height and slope at the
// window's centre. A plane through a round object lies inside of it, so two cameras would disagree.
class Bowl {
 public:
  void fit(const std::vector<Sample>& samples, Plane& plane) const {
    Vector6 sums = Vector6::Zero();
    std::size_t near = 0;
    for (const Sample& sample : samples) {
      if (!lies_near(sample, plane)) continue;
      sums += (sample.steps - plane.at(sample.dx, sample.dy)) * terms(sample);
      ++near;
    }
    if (near == kSamples) {  // In the usual case, the normal equations are constant.
      plane = bent(plane, whole_window_ * sums);
      return;
    }
    Matrix6 A = stiffness();
    for (const Sample& sample : samples) {
      if (lies_near(sample, plane)) A += terms(sample) * terms(sample).transpose();
    }
    plane = bent(plane, A.llt().solve(sums));
  }

 private:
  using Vector6 = Eigen::Matrix<float, 6, 1>;
  using Matrix6 = Eigen::Matrix<float, 6, 6>;

  static bool lies_near(const Sample& sample, const Plane& plane) {
    return std::abs(sample.steps - plane.at(sample.dx, sample.dy)) <= 2;
  }
  static Vector6 terms(const Sample& s) {
    return Vector6(1, s.dx, s.dy, s.dx * s.dx, s.dx * s.dy, s.dy * s.dy);
  }
  // Prior on the curvature: about two steps over the window. Windows whose samples lie on one side
  // need this prior.
  static Matrix6 stiffness() { return Vector6(0, 0, 0, 50, 50, 50).asDiagonal(); }
  static Matrix6 invert_whole_window() {
    Matrix6 A = stiffness();
    for (int dy = -kRadius; dy <= kRadius; dy += 2) {
      for (int dx = -kRadius; dx <= kRadius; dx += 2) {
        const Vector6 t = terms({static_cast<float>(dx), static_cast<float>(dy), 0});
        A += t * t.transpose();
      }
    }
    return A.inverse();
  }
  static Plane bent(const Plane& plane, const Vector6& by) {
    return {plane.along_x + by[1], plane.along_y + by[2], plane.here + by[0]};
  }

  Matrix6 whole_window_ = invert_whole_window();
};

// Expected error of a point along its normal: depth noise (Khoshelham and Elberink 2012), and
// lateral noise on a slanted surface (Nguyen, Izadi and Lovell 2012).
float sigma_along_normal(float z, float cosine, double fx) {
  const float theta = std::acos(std::clamp(cosine, 0.0f, 1.0f));
  const float sine = std::sin(theta);
  const auto right_angle = static_cast<float>(std::numbers::pi / 2);
  const float lateral_px = 0.8f + 0.035f * theta / std::max(right_angle - theta, 0.1f);
  const float lateral = lateral_px * z / static_cast<float>(fx) * sine;
  const float axial = static_cast<float>(kKinectV1Noise.sigma_m(z)) * cosine;
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
  const Bowl bowl;
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
      const auto on_first = [&first](const Sample& s) { return first.at(s.dx, s.dy); };
      if (!fit(
              samples, on_first, [](const Sample&) { return 2.0f; }, plane))
        continue;
      bowl.fit(samples, plane);
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

}  // namespace copresence::calibrate
