#include "tools/depth_bench/holoimage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

namespace copresence::depth_bench {
namespace {

constexpr int kWidth = 320, kHeight = 4;

depth::DepthFormat millimetres() {
  return {.width = kWidth, .height = kHeight, .unit = DepthUnit::kMillimetre, .range = {0.4, 5.0}};
}

template <class DepthAt>
DepthImage scene(const DepthAt& depth_at) {
  DepthImage depth(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) depth.row(y)[x] = static_cast<std::uint16_t>(depth_at(x));
  }
  return depth;
}

DepthImage there_and_back(const DepthImage& depth) {
  const Holoimage holoimage(millimetres());
  DepthImage back(kWidth, kHeight);
  holoimage.decode(holoimage.encode(depth), back);
  return back;
}

TEST(Holoimage, KeepsAWallToAFewMillimetres) {
  for (const int z : {400, 1000, 2750, 5000}) {
    const DepthImage back = there_and_back(scene([z](int) { return z; }));
    for (const std::uint16_t pixel : back.pixels()) ASSERT_NEAR(pixel, z, 3);
  }
}

TEST(Holoimage, KeepsAWallThatIsSlantedToEitherSide) {
  for (const int slope : {-2, 2}) {
    const DepthImage depth = scene([slope](int x) { return 2000 + slope * x; });
    const DepthImage back = there_and_back(depth);
    for (int x = 0; x < kWidth; ++x) ASSERT_NEAR(back.row(1)[x], depth.row(1)[x], 3) << x;
  }
}

TEST(Holoimage, LosesWhatLiesInTheShadowOfABoxOnTheSideAwayFromTheProjector) {
  // The projector stands 30 degrees to the right of the camera. The box is 40 pixels wide and stands 1 m before the
  // wall. It hides 40 pixels of the wall, 1 m * tan(30 degrees) = 134 pixels to its left.
  const DepthImage back = there_and_back(scene([](int x) { return x >= 140 && x < 180 ? 2000 : 3000; }));
  const auto lost = [&](int from, int to) {
    return std::count(back.row(0).begin() + from, back.row(0).begin() + to, 0);
  };
  EXPECT_EQ(lost(0, 3), 0);
  EXPECT_NEAR(double(lost(3, 49)), 40, 4);
  EXPECT_EQ(lost(49, kWidth), 0);
}

TEST(Holoimage, KeepsHoles) {
  const DepthImage back = there_and_back(scene([](int x) { return x % 7 == 0 ? 0 : 1500; }));
  for (int x = 0; x < kWidth; ++x) EXPECT_EQ(back.row(2)[x] == 0, x % 7 == 0);
}

}  // namespace
}  // namespace copresence::depth_bench
