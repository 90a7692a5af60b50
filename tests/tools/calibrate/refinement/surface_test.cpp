#include "tools/calibrate/refinement/surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/calibrate/refinement/scenes.h"

namespace copresence::calibrate {
namespace {

const std::vector<test::Box> kRoom{{{-2, -2, -2}, {2, 2, 2}}};

TEST(Surface, FindsASlantedWallExactly) {
  const Rigid3 pose = test::look_from({0, 0, 0}, {0.8, 0.2, 2});
  const Surface surface =
      make_surface(test::depth_of(kRoom, test::small_camera(), pose), test::small_camera());
  const Eigen::Vector3d normal = pose.rotation * surface.normal(160, 120).cast<double>();
  const Eigen::Vector3d point = pose * surface.point(160, 120).cast<double>();
  EXPECT_NEAR(normal.dot(Eigen::Vector3d(0, 0, -1)), 1, 1e-6);
  EXPECT_NEAR(point.z(), 2, 1e-4);
}

TEST(Surface, NormalsOfANoisyWallAreWithinAFewDegrees) {
  const Rigid3 pose = test::look_from({0, 0, 0}, {0.8, 0.2, 2});
  const Surface surface =
      make_surface(test::depth_of(kRoom, test::small_camera(), pose, 1), test::small_camera());
  std::vector<double> degrees;
  for (int y = 100; y < 140; ++y) {
    for (int x = 140; x < 180; ++x) {
      if (surface.sigma(x, y) == 0) continue;
      const Eigen::Vector3d normal = pose.rotation * surface.normal(x, y).cast<double>();
      degrees.push_back(std::acos(std::min(1.0, -normal.z())) * 180 / M_PI);
    }
  }
  ASSERT_GT(degrees.size(), 1500u);
  std::sort(degrees.begin(), degrees.end());
  EXPECT_LT(degrees[degrees.size() / 2], 6);
}

TEST(Surface, ExpectsMoreErrorFartherAway) {
  const auto sigma_at = [](double z) {
    const std::vector<test::Box> wall{{{-9, -9, -9}, {9, 9, z}}};
    return make_surface(test::depth_of(wall, test::small_camera(), {}), test::small_camera()).sigma(160, 120);
  };
  EXPECT_NEAR(sigma_at(2), kKinectV1Noise.sigma_m(2), 1e-4);
  EXPECT_NEAR(sigma_at(4) / sigma_at(2), 4, 0.05);
}

TEST(Surface, NoPlaneAcrossAnEdge) {
  const std::vector<test::Box> two{{{-9, -9, -9}, {9, 9, 3}}, {{0, -9, 1}, {9, 9, 1.2}}};
  const Surface surface = make_surface(test::depth_of(two, test::small_camera(), {}), test::small_camera());
  for (int x = 0; x < 320; ++x) {
    if (surface.sigma(x, 120) == 0) continue;
    const float z = surface.point(x, 120).z();
    EXPECT_TRUE(std::abs(z - 1) < 1e-3 || std::abs(z - 3) < 1e-3) << x << ' ' << z;
    EXPECT_GT(-surface.normal(x, 120).z(), 0.999) << x;
  }
}

TEST(Surface, LeavesOutWhatIsBeyondTheRange) {
  const std::vector<test::Box> wall{{{-9, -9, -9}, {9, 9, 4.5}}};
  const Image<float> depth = test::depth_of(wall, test::small_camera(), {});
  EXPECT_EQ(make_surface(depth, test::small_camera(), 0.4f, 4.0f).measured, 0);
  EXPECT_GT(make_surface(depth, test::small_camera(), 0.4f, 5.0f).planar, 60000);
}

}  // namespace
}  // namespace copresence::calibrate
