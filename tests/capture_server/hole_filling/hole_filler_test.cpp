#include "capture_server/hole_filling/hole_filler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/capture_server/hole_filling/scenes.h"

namespace copresence::hole_filling {
namespace {

void fill(Method method, Scene& scene) {
  auto filler = open(method, Compute::kCpu, scene.format());
  ASSERT_TRUE(filler) << filler.error().what;
  ASSERT_TRUE((*filler)->fill(scene.frame));
}

class EveryMethod : public testing::TestWithParam<Method> {};

INSTANTIATE_TEST_SUITE_P(HoleFilling, EveryMethod, testing::ValuesIn(kMethods),
                         [](const auto& of) { return std::string(name(of.param)); });

TEST_P(EveryMethod, LeavesMeasuredDepthUntouchedAndStatesTrue) {
  Scene scene = Scene::make(160, 120, slanted_plane, speckle);
  const RgbdFrame before = scene.frame;
  fill(GetParam(), scene);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (before.state(x, y) == DepthState::kMeasured) {
        ASSERT_EQ(scene.frame.depth(x, y), before.depth(x, y));
        ASSERT_EQ(scene.frame.state(x, y), DepthState::kMeasured);
      } else {
        ASSERT_EQ(scene.frame.depth(x, y) == 0, scene.frame.state(x, y) == DepthState::kHole);
        ASSERT_NE(scene.frame.state(x, y), DepthState::kMeasured);
      }
    }
  }
}

TEST_P(EveryMethod, GivesTheSameEveryTime) {
  Scene first = Scene::make(160, 120, board_before_wall(70), speckle), second = first;
  auto filler = open(GetParam(), Compute::kCpu, first.format()).value();
  ASSERT_TRUE(filler->fill(first.frame));
  Scene other = Scene::make(160, 120, slanted_plane, speckle);
  ASSERT_TRUE(filler->fill(other.frame));  // what a filler saw before must not matter
  ASSERT_TRUE(filler->fill(second.frame));
  EXPECT_EQ(first.frame.depth, second.frame.depth);
  EXPECT_EQ(first.frame.state, second.frame.state);
}

TEST_P(EveryMethod, LivesWithNothingMeasuredAndNothingMissing) {
  Scene nothing = Scene::make(64, 48, slanted_plane, [](int, int) { return true; });
  fill(GetParam(), nothing);
  EXPECT_EQ(nothing.count(DepthState::kHole), 64 * 48);
  Scene everything = Scene::make(64, 48, slanted_plane, [](int, int) { return false; });
  fill(GetParam(), everything);
  EXPECT_EQ(everything.frame.depth, everything.truth);
}

TEST_P(EveryMethod, LivesWithTinyAndOddlyShapedImages) {
  for (const auto& [width, height] : {std::pair{2, 2}, {2, 64}, {64, 2}, {6, 10}, {18, 14}, {30, 22}}) {
    Scene scene = Scene::make(width, height, slanted_plane, [](int x, int y) { return (x + y) % 3 == 0; });
    scene.frame.color = ColorImage(width, height, {10, 20, 30});
    fill(GetParam(), scene);
    EXPECT_GT(scene.count(DepthState::kMeasured), 0);
  }
}

TEST_P(EveryMethod, NeverFillsOutsideTheRange) {
  Scene scene = Scene::make(
      64, 48, [](int, int) { return 5.5; }, speckle);
  fill(GetParam(), scene);
  EXPECT_EQ(scene.count(DepthState::kFilled), 0);
}

TEST(HoleFilling, OffChangesNothing) {
  Scene scene = Scene::make(160, 120, slanted_plane, speckle);
  const RgbdFrame before = scene.frame;
  fill(Method::kOff, scene);
  EXPECT_EQ(scene.frame.depth, before.depth);
  EXPECT_EQ(scene.frame.state, before.state);
}

TEST(HoleFilling, EveryFillerClosesSmallHolesOfAPlaneWithinAStep) {
  for (const Method method : {Method::kMedian, Method::kBilateral, Method::kJoint}) {
    Scene scene = Scene::make(160, 120, slanted_plane, speckle);
    fill(method, scene);
    int missing = 0;
    double worst = 0;
    for (int y = 4; y < 116; ++y) {
      for (int x = 4; x < 156; ++x) {
        missing += scene.frame.state(x, y) == DepthState::kHole;
        if (scene.frame.state(x, y) == DepthState::kFilled) {
          worst = std::max(worst, steps_apart(scene.frame.depth(x, y), scene.truth(x, y)));
        }
      }
    }
    EXPECT_LE(missing, 20) << name(method);
    EXPECT_LE(worst, method == Method::kJoint ? 1.0 : 2.0) << name(method);
  }
}

TEST(HoleFilling, JointExtendsASlantedPlaneOverWideHoles) {
  Scene scene = Scene::make(160, 120, slanted_plane,
                            [](int x, int y) { return x >= 50 && x < 80 && y >= 30 && y < 90; });
  fill(Method::kJoint, scene);
  EXPECT_EQ(scene.count(DepthState::kHole), 0);
  for (int y = 30; y < 90; ++y) {
    for (int x = 50; x < 80; ++x)
      EXPECT_LE(steps_apart(scene.frame.depth(x, y), scene.truth(x, y)), 1) << x << ", " << y;
  }
}

/// A wide shadow: the board ends at 70, the wall is measured again from 70 + width on.
class WideShadow : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(HoleFilling, WideShadow, testing::Values(1, 3, 5, 8, 13, 20, 30, 38));

TEST_P(WideShadow, BelongsToTheFartherSurface) {
  const int end = 70 + GetParam();
  Scene scene = Scene::make(160, 120, board_before_wall(70), [&](int x, int) { return x >= 70 && x < end; });
  fill(Method::kJoint, scene);
  EXPECT_EQ(scene.count(DepthState::kHole), 0);
  for (int y = 0; y < 120; ++y) {
    for (int x = 70; x < end; ++x)
      ASSERT_LE(steps_apart(scene.frame.depth(x, y), 30000), 1) << x << ", " << y;
  }
}

TEST(HoleFilling, JointBridgesNoStepEdge) {
  const auto edge = [](int y) { return 60 + y / 4; };  // a slanted edge with ragged, speckled holes along it
  Scene scene = Scene::make(
      160, 120, [&](int x, int y) { return x < edge(y) ? 1.0 : 2.0; },
      [&](int x, int y) { return speckle(x, y) || (x >= edge(y) - 2 && x < edge(y) + 3 + y % 5); });
  fill(Method::kJoint, scene);
  for (const std::uint16_t depth : scene.frame.depth.pixels()) {
    if (depth == 0) continue;
    EXPECT_LE(std::min(steps_apart(depth, 10000), steps_apart(depth, 20000)), 1) << depth;
  }
}

TEST(HoleFilling, JointKeepsTheInsideOfANearThing) {
  Scene scene = Scene::make(160, 120, board_before_wall(70), [](int x, int y) {
    return x >= 60 && x < 66 && y >= 50 && y < 58;  // a dark button on the board, close to its edge
  });
  fill(Method::kJoint, scene);
  for (int y = 50; y < 58; ++y) {
    for (int x = 60; x < 66; ++x) EXPECT_LE(steps_apart(scene.frame.depth(x, y), 10000), 1) << x << ", " << y;
  }
}

TEST(HoleFilling, JointBelievesColorWhereTwoSurfacesMayBe) {
  // A hole on both sides of the board's edge: only colour tells where the edge runs.
  Scene scene = Scene::make(160, 120, board_before_wall(70), [](int x, int) { return x >= 64 && x < 84; });
  scene.frame.color = ColorImage(160, 120, {200, 30, 30});
  for (int y = 0; y < 120; ++y) {
    for (int x = 70; x < 160; ++x) (*scene.frame.color)(x, y) = {30, 30, 200};
  }
  fill(Method::kJoint, scene);
  int wrong = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 64; x < 84; ++x) wrong += steps_apart(scene.frame.depth(x, y), scene.truth(x, y)) > 1;
  }
  EXPECT_EQ(wrong, 0);
}

TEST(HoleFilling, LeavesWhatNobodyCanKnow) {
  for (const Method method : {Method::kMedian, Method::kJoint}) {
    Scene scene = Scene::make(160, 120, slanted_plane, [](int x, int y) {
      return x < 20 || x >= 140 ||
             (x >= 60 && x < 110 && y >= 30 && y < 90);  // border bands, and a large hole
    });
    fill(method, scene);
    EXPECT_EQ(scene.frame.state(10, 60), DepthState::kHole) << name(method);
    EXPECT_EQ(scene.frame.state(155, 60), DepthState::kHole) << name(method);
    EXPECT_EQ(scene.frame.state(85, 60), DepthState::kHole) << name(method);
  }
}

TEST(HoleFilling, RefusesSizesAndRangesThatMakeNoSense) {
  for (const FrameFormat& format :
       {FrameFormat{0, 480, kUnit, {}}, FrameFormat{641, 480, kUnit, {}},
        FrameFormat{640, 480, kUnit, {5, 1}}, FrameFormat{640, 480, kUnit, {-1, 1}},
        FrameFormat{640, 480, kUnit, {0.4, std::nan("")}}}) {
    EXPECT_EQ(open(Method::kJoint, Compute::kCpu, format).error().code, ErrorCode::kInvalid);
  }
}

}  // namespace
}  // namespace copresence::hole_filling
