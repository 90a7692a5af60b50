// Depth images of a wall, before which a box moves.

#include "render_client/moving_surfaces/motion_detector.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render_client/renderer/surfaces.h"

namespace copresence::moving_surfaces {
namespace {

constexpr int kWidth = 640, kHeight = 480, kBlock = 8;
constexpr int kLeft = 200, kRight = 230, kTop = 160, kBottom = 320;  // The box.
constexpr std::uint16_t kWall = 30000, kBox = 15000;                 // In units of 0.1 mm.

// A wall as a Kinect measures it, with a box that is `moved` pixels to the right.
DepthImage box(int moved, unsigned noise) {
  RgbdFrame frame;
  frame.depth = DepthImage(kWidth, kHeight, kWall);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  for (int y = kTop; y < kBottom; ++y) std::fill_n(&frame.depth(kLeft + moved, y), kRight - kLeft, kBox);
  renderer::measure_like_a_kinect(frame, 0.04, noise);
  return frame.depth;
}

class MotionDetectorTest : public ::testing::Test {
 protected:
  MotionDetectorTest() { detector_.begin(DepthUnit::k100Micrometres, kKinectV1Noise); }

  MotionDetector detector_;
};

TEST_F(MotionDetectorTest, FindsNothingInAStillNoisyPicture) {
  for (unsigned i = 0; i < 20; ++i) EXPECT_TRUE(detector_.detect(box(0, i)).empty()) << i;
}

TEST_F(MotionDetectorTest, FindsTheWholeBoxThatMovesSidewaysAndNothingElse) {
  constexpr int kStep = 8, kFrames = 6;
  for (int i = 0; i < kFrames - 1; ++i) detector_.detect(box(kStep * i, unsigned(i)));
  const MovingBlocks moving = detector_.detect(box(kStep * (kFrames - 1), 9));
  ASSERT_EQ(moving.width(), kWidth / kBlock);
  ASSERT_EQ(moving.height(), kHeight / kBlock);
  const int left = kLeft + kStep * (kFrames - 1), right = left + kRight - kLeft;
  for (int y = kTop; y < kBottom; y += kBlock) {
    for (int x = left; x < right; ++x) EXPECT_TRUE(moving(x / kBlock, y / kBlock)) << x << ' ' << y;
  }
  for (int j = 0; j < moving.height(); ++j) {
    for (int i = 0; i < moving.width(); ++i) {
      const int x = i * kBlock, y = j * kBlock;
      if (x > right + kBlock || x < kLeft - 2 * kBlock || y < kTop - 2 * kBlock || y > kBottom + kBlock) {
        EXPECT_FALSE(moving(i, j)) << x << ' ' << y;
      }
    }
  }
}

TEST_F(MotionDetectorTest, FindsABoxThatComesNearer) {
  DepthImage before(kWidth, kHeight, kWall), after = before;
  for (int y = kTop; y < kBottom; ++y) {
    std::fill_n(&before(kLeft, y), kRight - kLeft, kBox);
    std::fill_n(&after(kLeft, y), kRight - kLeft, std::uint16_t(kBox - 300));
  }
  detector_.detect(before);
  EXPECT_TRUE(detector_.detect(after)((kLeft + 12) / kBlock, (kTop + 12) / kBlock));
}

TEST_F(MotionDetectorTest, ForgetsAMotionAfterSomeFrames) {
  detector_.detect(box(0, 1));
  for (int i = 0; i < MotionDetector::kFrames; ++i) EXPECT_FALSE(detector_.detect(box(20, 1)).empty()) << i;
  EXPECT_TRUE(detector_.detect(box(20, 1)).empty());
}

TEST_F(MotionDetectorTest, FindsNothingWhileTheCameraMoves) {
  for (int i = 0; i < 5; ++i) {
    const auto nearer = static_cast<std::uint16_t>(kWall - 2000 * i);
    EXPECT_TRUE(detector_.detect(DepthImage(kWidth, kHeight, nearer)).empty()) << i;
  }
}

TEST_F(MotionDetectorTest, TakesHolesForNoMotion) {
  detector_.detect(DepthImage(kWidth, kHeight, kWall));
  DepthImage hole(kWidth, kHeight, kWall);
  for (int y = kTop; y < kBottom; ++y) std::fill_n(&hole(kLeft, y), kRight - kLeft, std::uint16_t{0});
  EXPECT_TRUE(detector_.detect(hole).empty());
  EXPECT_TRUE(detector_.detect(DepthImage(kWidth, kHeight, kWall)).empty());
}

TEST_F(MotionDetectorTest, TakesPicturesOfAnySize) {
  for (const auto& [width, height] :
       {std::pair(320, 240), std::pair(1280, 720), std::pair(6, 2), std::pair(2, 6)}) {
    detector_.detect(DepthImage(width, height, kWall));
    EXPECT_TRUE(detector_.detect(DepthImage(width, height, kWall)).empty());
  }
}

}  // namespace
}  // namespace copresence::moving_surfaces
