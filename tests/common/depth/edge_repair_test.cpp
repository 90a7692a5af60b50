#include "common/depth/edge_repair.h"

#include <gtest/gtest.h>

namespace copresence::depth {
namespace {

TEST(EdgeRepair, PutsAPixelThatHangsBetweenTwoSurfacesBackOnTheNearerOne) {
  DepthImage depth(16, 8, 1000);
  for (int y = 0; y < 8; ++y) {
    for (int x = 8; x < 16; ++x) depth(x, y) = 2000;
  }
  const DepthImage whole = depth;
  EdgeRepair repair(DepthUnit::kMillimetre, kKinectV1Noise);
  repair.repair(depth);
  EXPECT_EQ(depth, whole) << "a clean edge stays";
  for (int y = 0; y < 8; ++y) {
    depth(7, y) = 1100;
    depth(8, y) = 1700;
  }
  repair.repair(depth);
  EXPECT_EQ(depth, whole);
  for (int y = 0; y < 8; ++y) depth(8, y) = 1333;  // half way in steps: either side may be right
  const DepthImage unsure = depth;
  repair.repair(depth);
  EXPECT_EQ(depth, unsure);
}

TEST(EdgeRepair, LeavesSlantedSurfacesAlone) {
  DepthImage depth(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) depth(x, y) = static_cast<std::uint16_t>(1500 + 12 * x + 5 * y);
  }
  const DepthImage before = depth;
  EdgeRepair(DepthUnit::kMillimetre, kKinectV1Noise).repair(depth);
  EXPECT_EQ(depth, before);
}

}  // namespace
}  // namespace copresence::depth
