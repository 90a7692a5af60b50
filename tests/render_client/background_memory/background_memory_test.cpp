#include "render_client/background_memory/background_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace copresence::background_memory {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr std::uint16_t kWall = 3000, kBox = 1500;  // mm
constexpr Rgb8 kWallColor{90, 120, 150}, kBoxColor{200, 30, 30};
constexpr int kLeft = 60, kRight = 100, kTop = 40, kBottom = 80;  // of the box

bool is_in_box(int x, int y, int moved = 0) {
  return x >= kLeft + moved && x < kRight + moved && y >= kTop && y < kBottom;
}

RgbdFrame wall(std::uint16_t z = kWall, Rgb8 color = kWallColor) {
  RgbdFrame frame;
  frame.depth = DepthImage(kWidth, kHeight, z);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  frame.color = ColorImage(kWidth, kHeight, color);
  return frame;
}

// A box before the wall. Its colour also lies on the wall, up to `halo` pixels beside it.
RgbdFrame box(int moved = 0, int halo = 0) {
  RgbdFrame frame = wall();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (is_in_box(x, y, moved)) frame.depth(x, y) = kBox;
      if (is_in_box(x - halo, y, moved) || is_in_box(x + halo, y, moved)) (*frame.color)(x, y) = kBoxColor;
    }
  }
  return frame;
}

class BackgroundMemoryTest : public ::testing::Test {
 protected:
  BackgroundMemoryTest() { memory_.begin(DepthUnit::kMillimetre, kKinectV1Noise); }

  void learn(const RgbdFrame& frame, int times = 1) {
    for (int i = 0; i < times; ++i) memory_.learn(frame);
  }
  // Number of the box's pixels behind which the wall is remembered.
  int walls_behind(int moved = 0) const {
    int count = 0;
    for (int y = 0; y < kHeight && memory_.covered(); ++y) {
      for (int x = 0; x < kWidth; ++x)
        count += is_in_box(x, y, moved) && std::abs(memory_.covered()->depth(x, y) - kWall) < 30;
    }
    return count;
  }

  BackgroundMemory memory_;
  static constexpr int kBoxPixels = (kRight - kLeft) * (kBottom - kTop);
};

TEST_F(BackgroundMemoryTest, RemembersTheWallBehindABox) {
  learn(wall(), 20);
  EXPECT_EQ(memory_.covered(), nullptr);
  learn(box());
  ASSERT_NE(memory_.covered(), nullptr);
  EXPECT_EQ(walls_behind(), kBoxPixels);
  EXPECT_EQ((*memory_.covered()->color)(80, 60), kWallColor);
  EXPECT_EQ(memory_.covered()->depth(4, 4), 0) << "far from the box nothing is covered";
}

TEST_F(BackgroundMemoryTest, RemembersTheWallThatABoxHasUncovered) {
  learn(box(), 30);
  EXPECT_EQ(memory_.covered(), nullptr);
  learn(wall(), kSteadyFrames + 6);  // Its colours are taken within six frames.
  learn(box());
  EXPECT_EQ(walls_behind(), kBoxPixels);
}

TEST_F(BackgroundMemoryTest, DoesNotRememberWhatItHasSeenBriefly) {
  learn(box(), 30);
  learn(wall(), kSteadyFrames - 1);
  learn(box());
  EXPECT_EQ(walls_behind(), 0);
}

TEST_F(BackgroundMemoryTest, FillsHolesWithWhatWasMeasuredThere) {
  learn(wall(), 20);
  RgbdFrame holes = wall();
  for (int y = kTop; y < kBottom; ++y) {
    for (int x = kLeft; x < kRight; ++x) {
      holes.depth(x, y) = 0;
      holes.state(x, y) = DepthState::kHole;
    }
  }
  learn(holes);
  EXPECT_EQ(walls_behind(), kBoxPixels);
}

TEST_F(BackgroundMemoryTest, TakesNoColorBesideASilhouette) {
  learn(wall(), 20);
  learn(box(0, 3), 30);  // its colour lies on the wall beside it
  learn(box(20), 1);
  ASSERT_NE(memory_.covered(), nullptr);
  for (int x = kLeft + 20; x < kRight + 20; ++x)
    EXPECT_EQ((*memory_.covered()->color)(x, 60), kWallColor) << x;
}

TEST_F(BackgroundMemoryTest, HasColorsBesideTheDrawnPixelsToo) {
  learn(wall(), 20);
  learn(box());
  ASSERT_NE(memory_.covered(), nullptr);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      ASSERT_EQ((*memory_.covered()->color)(x, y), kWallColor) << x << ' ' << y;
  }
}

TEST_F(BackgroundMemoryTest, FollowsTheLight) {
  for (int level = 0; level < 60; ++level) {
    const auto darker = static_cast<std::uint8_t>(kWallColor.r - level);
    learn(wall(kWall, {darker, kWallColor.g, kWallColor.b}), 6);
  }
  RgbdFrame dark = wall(kWall, {kWallColor.r - 59, kWallColor.g, kWallColor.b});
  for (int y = kTop; y < kBottom; ++y) std::fill_n(&dark.depth(kLeft, y), kRight - kLeft, kBox);
  learn(dark);
  ASSERT_NE(memory_.covered(), nullptr);
  EXPECT_NEAR((*memory_.covered()->color)(80, 60).r, kWallColor.r - 59, 5);
}

TEST_F(BackgroundMemoryTest, ForgetsWhenTheCameraMovesBack) {
  learn(wall(), 20);
  learn(wall(kWall + 400));
  learn(box());
  EXPECT_EQ(memory_.covered(), nullptr);
}

TEST_F(BackgroundMemoryTest, ForgetsWhenTheCameraTurnsTowardsAnotherWall) {
  learn(wall(), 20);
  learn(wall(kWall, {20, 200, 20}), 6);
  learn(box());
  EXPECT_EQ(memory_.covered(), nullptr);
}

TEST_F(BackgroundMemoryTest, ForgetsWhenThePoseChanges) {
  learn(wall(), 20);
  RgbdFrame moved = box();
  moved.metadata.world_from_camera.translation.x() = 0.1;
  learn(moved);
  EXPECT_EQ(memory_.covered(), nullptr);
}

TEST_F(BackgroundMemoryTest, KeepsTheSameFrameWhileTheCoveredPartStays) {
  learn(wall(), 20);
  learn(box());
  const auto first = memory_.covered();
  learn(box(), 5);
  EXPECT_EQ(memory_.covered(), first);
  learn(box(1));
  EXPECT_EQ(memory_.covered(), first) << "one pixel farther still lies inside what was drawn";
  learn(box(24));
  EXPECT_NE(memory_.covered(), first);
  EXPECT_EQ(walls_behind(24), kBoxPixels);
}

TEST_F(BackgroundMemoryTest, DropsARememberedSurfaceAsSoonAsSomethingFartherIsSeen) {
  // The box stands for so long that it counts as background. A hand covers its left half, then the box goes away.
  learn(box(), 30);
  RgbdFrame hand = box();
  for (int y = kTop; y < kBottom; ++y) std::fill_n(&hand.depth(kLeft, y), 20, std::uint16_t{900});
  learn(hand);
  ASSERT_NE(memory_.covered(), nullptr);
  EXPECT_NEAR(memory_.covered()->depth(kLeft + 25, 60), kBox, 5);
  for (int y = kTop; y < kBottom; ++y) std::fill_n(&hand.depth(kLeft + 20, y), 20, kWall);
  learn(hand);
  ASSERT_NE(memory_.covered(), nullptr);
  EXPECT_EQ(memory_.covered()->depth(kLeft + 25, 60), 0);
  EXPECT_NEAR(memory_.covered()->depth(kLeft + 5, 60), kBox, 5);
}

TEST_F(BackgroundMemoryTest, WorksWithoutColor) {
  RgbdFrame gray = wall(), before = box();
  gray.color.reset();
  before.color.reset();
  learn(gray, 20);
  learn(before);
  EXPECT_EQ(walls_behind(), kBoxPixels);
  EXPECT_FALSE(memory_.covered()->color);
}

}  // namespace
}  // namespace copresence::background_memory
