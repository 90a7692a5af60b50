#include "render_client/decoding/depth_smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

namespace copresence::decoding {
namespace {

TEST(DepthSmoothing, LeavesAPlaneAcrossTheAxisAsItIs) {
  DepthImage depth(64, 48, 2000);
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
  EXPECT_EQ(depth, DepthImage(64, 48, 2000));
}

TEST(DepthSmoothing, TakesMostOfTheGrainOutOfASurface) {
  DepthImage depth(64, 48);
  std::minstd_rand random(1);
  std::uniform_int_distribution<int> level(-1, 1);  // a Kinect's step at 3 m is 25.6 mm
  for (auto& z : depth.pixels()) z = static_cast<std::uint16_t>(3000 + 26 * level(random));
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
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
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
  EXPECT_EQ(depth, before);
}

TEST(DepthSmoothing, KeepsHolesAndDoesNotLetThemPull) {
  DepthImage depth(64, 48, 2000);
  for (int y = 10; y < 20; ++y) {
    for (int x = 20; x < 40; ++x) depth(x, y) = 0;
  }
  const DepthImage before = depth;
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
  EXPECT_EQ(depth, before);
}

TEST(DepthSmoothing, KnowsTheUnit) {
  DepthImage depth(16, 16, 20000);  // 2 m; a step is 11.4 mm
  depth(8, 8) = 20200;              // 20 mm away: the same surface
  DepthSmoothing smoothing;
  smoothing.smooth(depth, DepthUnit::k100Micrometres, kKinectV1Noise);
  EXPECT_LT(depth(8, 8), 20060);
  DepthImage far(16, 16, 20000);
  far(8, 8) = 20600;  // 60 mm away: another surface
  smoothing.smooth(far, DepthUnit::k100Micrometres, kKinectV1Noise);
  EXPECT_EQ(far(8, 8), 20600);
}

TEST(DepthSmoothing, IsNotPulledByTheFarEndOfTheNumbers) {
  // The farthest depth and a hole beside it differ by one step modulo 2^16.
  for (const int beside : {0, 1, 500, 3000}) {
    DepthImage depth(32, 32, 65000);
    for (int y = 0; y < 32; ++y) {
      for (int x = 16; x < 32; ++x) depth(x, y) = static_cast<std::uint16_t>(beside);
    }
    const DepthImage before = depth;
    DepthSmoothing().smooth(depth, DepthUnit::k100Micrometres, kKinectV1Noise);
    EXPECT_EQ(depth, before) << beside;
  }
}

// The mean along one axis, as the header defines it.
std::vector<double> smoothed_along(const std::vector<double>& depth, double tolerance_per_square) {
  std::vector<double> out = depth;
  const int count = static_cast<int>(depth.size());
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    int taps = 0;
    for (int k = std::max(i - DepthSmoothing::kRadius, 0);
         k <= std::min(i + DepthSmoothing::kRadius, count - 1); ++k) {
      if (std::abs(depth[k] - depth[i]) > tolerance_per_square * depth[i] * depth[i]) continue;
      sum += depth[k];
      ++taps;
    }
    out[i] = sum / taps;
  }
  return out;
}

TEST(DepthSmoothing, TakesTheMeanAlongRowsThenColumns) {
  // Levels so far from the tolerance that rounding between rows and columns does not change which
  // pixels belong to a surface.
  const int width = 75, height = 41;
  DepthImage depth(width, height);
  std::minstd_rand random(3);
  std::uniform_int_distribution<int> surface(0, 3), noise(-6, 6);
  for (auto& z : depth.pixels()) {
    const int which = surface(random);
    z = static_cast<std::uint16_t>(which == 0 ? 0 : 1000 + 700 * which + noise(random));
  }
  const double tolerance_per_square =
      DepthSmoothing::kSameSurface * kKinectV1Noise.step_m(1.0) * metres_per_unit(DepthUnit::kMillimetre);
  std::vector<std::vector<double>> rows;
  for (int y = 0; y < height; ++y) {
    const auto row = depth.row(y);
    rows.push_back(smoothed_along({row.begin(), row.end()}, tolerance_per_square));
  }
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
  for (int x = 0; x < width; ++x) {
    std::vector<double> column;
    for (int y = 0; y < height; ++y) column.push_back(rows[y][x]);
    column = smoothed_along(column, tolerance_per_square);
    for (int y = 0; y < height; ++y) EXPECT_NEAR(depth(x, y), column[y], 1.1) << x << ' ' << y;
  }
}

TEST(DepthSmoothing, TakesImagesSmallerThanItself) {
  DepthImage depth(2, 2, 1000);
  DepthSmoothing().smooth(depth, DepthUnit::kMillimetre, kKinectV1Noise);
  EXPECT_EQ(depth, DepthImage(2, 2, 1000));
}

}  // namespace
}  // namespace copresence::decoding
