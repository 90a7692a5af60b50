#include "render_client/renderer/shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render_client/renderer/merge_rules.h"
#include "tests/render_client/renderer/surfaces.h"

namespace copresence::renderer {
namespace {

/// A surface whose depths are levels of a Kinect.
DepthImage measured_in_levels(const CameraModel& model, const Surface& surface) {
  RgbdFrame frame = frame_of(model, surface, std::nullopt);
  for (std::uint16_t& depth : frame.depth.pixels()) {
    if (depth == 0) continue;
    const double level = std::round(kKinectV1Noise.disparity_constant_m / (depth * 1e-4));
    depth = static_cast<std::uint16_t>(std::lround(kKinectV1Noise.disparity_constant_m / level * 1e4));
  }
  return frame.depth;
}

Image<float> shading_of(const Surface& surface) {
  Image<float> incidences;
  measure_shading(measured_in_levels(kinect_model(), surface), DepthUnit::k100Micrometres, kinect_model(),
                  incidences);
  return incidences;
}

TEST(Shading, AWallMeasuredInLevelsIsShadedEvenly) {
  for (const Eigen::Vector3d& normal : {Eigen::Vector3d(0.1, 0, 1), Eigen::Vector3d(-0.6, 0.2, 1)}) {
    const Image<float> incidences = shading_of(plane(normal, 3.2));
    const CameraModel model = kinect_model();
    double worst = 0;
    for (int y = 2; y < incidences.height() - 2; ++y) {
      for (int x = 2; x < incidences.width() - 2; ++x) {
        const Eigen::Vector3d ray((x * kCell + 4 - model.cx) / model.fx,
                                  (y * kCell + 4 - model.cy) / model.fy, 1);
        const double expected = normal.dot(ray) / (normal.norm() * ray.norm());
        if (3.2 / normal.dot(ray) > 5) continue;
        worst = std::max(worst, std::abs(incidences(x, y) - expected));
      }
    }
    EXPECT_LT(worst, 0.06);
  }
}

TEST(Shading, ASurfaceIsNotShadedByTheOneBehindIt) {
  const Surface post_and_wall = [](double x, double) -> std::optional<double> {
    return std::abs(x) < 0.15 ? 1.5 : 3.0;
  };
  const Image<float> incidences = shading_of(post_and_wall);
  for (int y = 0; y < incidences.height(); ++y) {
    for (int x = 10; x < incidences.width() - 10; ++x) ASSERT_GT(incidences(x, y), 0.8) << x << ' ' << y;
  }
}

TEST(Shading, ATableSeenFromCloseIsShadedEvenly) {
  const CameraModel model = kinect_model();
  const Eigen::Vector3d normal(0, 1, 0.25);
  const Image<float> incidences = shading_of(plane(normal, 0.35));
  for (int y = incidences.height() / 2 + 3; y < incidences.height() - 3; ++y) {
    for (int x = 3; x < incidences.width() - 3; ++x) {
      const Eigen::Vector3d ray((x * kCell + 4 - model.cx) / model.fx, (y * kCell + 4 - model.cy) / model.fy,
                                1);
      ASSERT_NEAR(incidences(x, y), normal.dot(ray) / (normal.norm() * ray.norm()), 0.06) << x << ' ' << y;
    }
  }
}

TEST(Shading, WithoutDepthTheNormalIsUnknown) {
  Image<float> incidences;
  measure_shading(DepthImage(24, 18), DepthUnit::kMillimetre, kinect_model(), incidences);
  EXPECT_EQ(incidences, Image<float>(3, 3, kUnknownIncidence));
}

}  // namespace
}  // namespace copresence::renderer
