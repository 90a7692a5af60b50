#include "render_client/depth_smoothing.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace copresence::client {
namespace {

TEST(DepthSmoothing, LeavesAPlaneAcrossTheAxisAsItIs) {
  DepthImage depth(64, 48, 2000);
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre);
  EXPECT_EQ(depth, DepthImage(64, 48, 2000));
}

TEST(DepthSmoothing, TakesMostOfTheGrainOutOfASurface) {
  DepthImage depth(64, 48);
  std::minstd_rand random(1);
  std::uniform_int_distribution<int> level(-1, 1);  // a Kinect's step at 3 m is 25.6 mm
  for (auto& z : depth.pixels()) z = static_cast<std::uint16_t>(3000 + 26 * level(random));
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre);
  for (int y = DepthSmoothing::kRadius; y < 48 - DepthSmoothing::kRadius; ++y) {
    for (int x = DepthSmoothing::kRadius; x < 64 - DepthSmoothing::kRadius; ++x) {
      EXPECT_NEAR(depth(x, y), 3000, 15) << x << ' ' << y;
    }
  }
}

TEST(DepthSmoothing, MixesNothingAcrossADiscontinuity) {
  DepthImage depth(64, 48, 1500);
  for (int y = 0; y < 48; ++y) {
    for (int x = 32; x < 64; ++x) depth(x, y) = 2500;
  }
  const DepthImage before = depth;
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre);
  EXPECT_EQ(depth, before);
}

TEST(DepthSmoothing, KeepsHolesAndDoesNotLetThemPull) {
  DepthImage depth(64, 48, 2000);
  for (int y = 10; y < 20; ++y) {
    for (int x = 20; x < 40; ++x) depth(x, y) = 0;
  }
  const DepthImage before = depth;
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre);
  EXPECT_EQ(depth, before);
}

TEST(DepthSmoothing, KnowsTheUnit) {
  DepthImage depth(16, 16, 20000);  // 2 m; a step is 11.4 mm
  depth(8, 8) = 20200;              // 20 mm off: the same surface
  DepthSmoothing smoothing;
  smoothing.smooth(depth, DepthUnit::k100Micrometres);
  EXPECT_LT(depth(8, 8), 20060);
  DepthImage far(16, 16, 20000);
  far(8, 8) = 20600;  // 60 mm off: another one
  smoothing.smooth(far, DepthUnit::k100Micrometres);
  EXPECT_EQ(far(8, 8), 20600);
}

TEST(DepthSmoothing, TakesImagesSmallerThanItself) {
  DepthImage depth(2, 2, 1000);
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre);
  EXPECT_EQ(depth, DepthImage(2, 2, 1000));
}

}  // namespace
}  // namespace copresence::client
