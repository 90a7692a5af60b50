#include "tools/calibrate/geometry/plane_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "simulation/sensor/simulated_kinect.h"

namespace copresence::calibrate {
namespace {

const CameraModel kModel = simulation::kinect_model(640, 480);
const std::vector<Eigen::Vector2d> kOutline{{300, 200}, {350, 205}, {345, 252}, {298, 248}};

// A slanted plane, z = 2 m + x / 2, in disparity steps of a Kinect, with an error of `noise` steps.
DepthImage slanted(std::uint32_t seed, double noise) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0, 1);
  DepthImage depth(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const double ray_x = unproject(kModel, {double(x), double(y)}, 1).x();
      const double z = 2 / (1 - 0.5 * ray_x);
      const double level = std::round(351.3 / z + noise * error(random));
      depth(x, y) = static_cast<std::uint16_t>(std::lround(1000 * 351.3 / level));
    }
  }
  return depth;
}

double true_z(const Eigen::Vector2d& ray) {
  return 2 / (1 - 0.5 * ray.x());
}

TEST(PlaneDepth, FindsASlantedPlaneToATenthOfAStep) {
  DepthAverage average(DepthUnit::kMillimetre);
  for (std::uint32_t frame = 0; frame < 5; ++frame) average.add(slanted(frame, 0.5));
  const auto plane = fit_plane(average, kModel, kOutline);
  ASSERT_TRUE(plane) << plane.error().what;
  const Eigen::Vector2d ray = unproject(kModel, {323, 226}, 1).head<2>();
  const double step = true_z(ray) * true_z(ray) / 351.3;
  EXPECT_NEAR(plane->z_along(ray), true_z(ray), 0.1 * step);
  EXPECT_GT(plane->share, 0.95);
  EXPECT_NEAR(plane->pixels, 50 * 47, 150);
  EXPECT_LT(plane->rms_steps, 0.5);
}

TEST(PlaneDepth, IsNotMovedByWhatStandsBeforeAThirdOfIt) {
  DepthAverage average(DepthUnit::kMillimetre);
  for (std::uint32_t frame = 0; frame < 5; ++frame) {
    DepthImage depth = slanted(frame, 0.3);
    for (int y = 190; y < 260; ++y) {
      for (int x = 295; x < 312; ++x) depth(x, y) = static_cast<std::uint16_t>(1200 + y);
    }
    average.add(depth);
  }
  const auto plane = fit_plane(average, kModel, kOutline);
  ASSERT_TRUE(plane) << plane.error().what;
  const Eigen::Vector2d ray = unproject(kModel, {323, 226}, 1).head<2>();
  EXPECT_NEAR(plane->z_along(ray), true_z(ray), 0.003);
  EXPECT_LT(plane->share, 0.8);
}

TEST(PlaneDepth, ForgetsThePersonWhoWalkedBy) {
  DepthAverage average(DepthUnit::kMillimetre);
  for (std::uint32_t frame = 0; frame < 8; ++frame) {
    DepthImage depth = slanted(frame, 0.3);
    if (frame == 4) std::fill(depth.pixels().begin(), depth.pixels().end(), std::uint16_t{900});
    average.add(depth);
  }
  const double z = 1 / average.inverse_depth(323, 226);
  EXPECT_NEAR(z, true_z(unproject(kModel, {323, 226}, 1).head<2>()), 0.012);
}

TEST(PlaneDepth, SaysWhyThereIsNoPlane) {
  DepthAverage holes(DepthUnit::kMillimetre);
  holes.add(DepthImage(640, 480));
  EXPECT_THAT(fit_plane(holes, kModel, kOutline).error().what,
              testing::HasSubstr("only 0 of its pixels have depth"));

  std::mt19937 random(3);
  std::uniform_int_distribution<int> anything(600, 4000);
  DepthImage noise(640, 480);
  for (auto& pixel : noise.pixels()) pixel = static_cast<std::uint16_t>(anything(random));
  DepthAverage average(DepthUnit::kMillimetre);
  average.add(noise);
  EXPECT_THAT(fit_plane(average, kModel, kOutline).error().what, testing::HasSubstr("no plane"));
  const std::vector<Eigen::Vector2d> outside{{-50, -50}, {-10, -50}, {-10, -10}, {-50, -10}};
  EXPECT_FALSE(fit_plane(average, kModel, outside));
}

}  // namespace
}  // namespace copresence::calibrate
