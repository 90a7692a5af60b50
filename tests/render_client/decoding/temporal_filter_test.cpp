#include "render_client/decoding/temporal_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace copresence::decoding {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::uint16_t kWall = 3000;  // mm; a sensor step is 25.6 mm there

RgbdFrame wall(std::uint16_t z = kWall, Rgb8 color = {90, 120, 150}) {
  RgbdFrame frame;
  frame.depth = DepthImage(kWidth, kHeight, z);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  frame.color = ColorImage(kWidth, kHeight, color);
  return frame;
}

/// The wall as a still Kinect measures it: some depths are a level higher or lower, and the colours
/// have grain.
RgbdFrame noisy_wall(std::minstd_rand& random) {
  std::uniform_int_distribution<int> level(-1, 1), grain(-3, 3);
  RgbdFrame frame = wall();
  for (auto& z : frame.depth.pixels()) z = static_cast<std::uint16_t>(kWall + 26 * level(random));
  for (Rgb8& pixel : frame.color->pixels()) pixel.r = static_cast<std::uint8_t>(90 + grain(random));
  return frame;
}

class TemporalFilterTest : public ::testing::Test {
 protected:
  RgbdFrame show(RgbdFrame frame) {
    filter_.apply(frame, DepthUnit::kMillimetre, kKinectV1Noise);
    return frame;
  }
  void show_wall(int frames) {
    for (int i = 0; i < frames; ++i) show(wall());
  }
  static void set_hole(RgbdFrame& frame, int x, int y) {
    frame.depth(x, y) = 0;
    frame.state(x, y) = DepthState::kHole;
  }

  TemporalFilter filter_;
};

TEST_F(TemporalFilterTest, ShowsTheFirstFrameAsItIs) {
  std::minstd_rand random(1);
  const RgbdFrame frame = noisy_wall(random), shown = show(frame);
  EXPECT_EQ(shown.depth, frame.depth);
  EXPECT_EQ(shown.color, frame.color);
}

TEST_F(TemporalFilterTest, QuietensTheNoiseOfAStillWall) {
  std::minstd_rand random(1);
  for (int i = 0; i < 20; ++i) show(noisy_wall(random));
  const RgbdFrame before = show(noisy_wall(random)), after = show(noisy_wall(random));
  double depth = 0, color = 0;
  for (std::size_t i = 0; i < before.depth.pixels().size(); ++i) {
    depth += std::abs(before.depth.data()[i] - after.depth.data()[i]);
    color += std::abs(before.color->data()[i].r - after.color->data()[i].r);
  }
  const double pixels = kWidth * kHeight;
  EXPECT_LT(depth / pixels, 4) << "mm; 23 as it comes";
  EXPECT_LT(color / pixels, 0.6) << "of 255; 2.3 as it comes";
  for (const std::uint16_t z : after.depth.pixels()) EXPECT_NEAR(z, kWall, 40);
}

TEST_F(TemporalFilterTest, AFrameWithoutColorInterruptsNothing) {
  std::minstd_rand random(1);
  for (int i = 0; i < 20; ++i) show(noisy_wall(random));
  const RgbdFrame before = show(noisy_wall(random));
  RgbdFrame colorless = noisy_wall(random);
  colorless.color.reset();
  const RgbdFrame without = show(colorless), after = show(noisy_wall(random));
  EXPECT_FALSE(without.color);
  double change = 0, change_after = 0;
  for (std::size_t i = 0; i < before.depth.pixels().size(); ++i) {
    change += std::abs(before.depth.data()[i] - without.depth.data()[i]);
    change_after += std::abs(without.depth.data()[i] - after.depth.data()[i]);
  }
  const double pixels = kWidth * kHeight;
  EXPECT_LT(change / pixels, 4) << "mm; 23 as it comes";
  EXPECT_LT(change_after / pixels, 4) << "mm; 23 as it comes";
}

TEST_F(TemporalFilterTest, ColorThatComesBackIsShownAsItIsAndMeansNoMotion) {
  std::minstd_rand random(1);
  for (int i = 0; i < 20; ++i) show(noisy_wall(random));
  RgbdFrame colorless = noisy_wall(random);
  colorless.color.reset();
  const RgbdFrame without = show(colorless);
  RgbdFrame bright = noisy_wall(random);
  for (Rgb8& pixel : bright.color->pixels()) pixel.g = 250;
  const ColorImage color = *bright.color;
  const RgbdFrame after = show(bright);
  EXPECT_EQ(after.color, color);
  double change = 0;
  for (std::size_t i = 0; i < after.depth.pixels().size(); ++i)
    change += std::abs(without.depth.data()[i] - after.depth.data()[i]);
  EXPECT_LT(change / (kWidth * kHeight), 4) << "mm; 23 as it comes";
}

TEST_F(TemporalFilterTest, ShowsAJumpOfAWholeThingAtOnce) {
  show_wall(10);
  RgbdFrame hand = wall();
  for (int y = 8; y < 24; ++y) {
    for (int x = 16; x < 40; ++x) {
      hand.depth(x, y) = 1500;
      (*hand.color)(x, y) = {200, 150, 130};
    }
  }
  const RgbdFrame shown = show(hand);
  EXPECT_EQ(shown.depth, hand.depth);
  EXPECT_EQ((*shown.color)(20, 10), (*hand.color)(20, 10));
  EXPECT_EQ(show(wall()).depth, wall().depth) << "and that it is gone again";
}

TEST_F(TemporalFilterTest, FollowsWhatComesNearerByLessThanAStepAFrame) {
  RgbdFrame frame = wall();
  for (int i = 0; i < 30; ++i) {
    frame = wall(static_cast<std::uint16_t>(kWall - 20 * i));
    // One part stands still, so that the camera does not count as moving.
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 24; x < kWidth; ++x) frame.depth(x, y) = kWall;
    }
    frame = show(frame);
  }
  EXPECT_NEAR(frame.depth(10, 10), kWall - 20 * 29, 26) << "at most a step behind";
  EXPECT_EQ(frame.depth(50, 10), kWall);
}

TEST_F(TemporalFilterTest, KeepsDepthThatFlickersOut) {
  show_wall(3);
  RgbdFrame frame = wall();
  set_hole(frame, 10, 10);
  for (int i = 0; i < TemporalFilter::kKeptFrames; ++i) {
    const RgbdFrame shown = show(frame);
    EXPECT_EQ(shown.depth(10, 10), kWall) << i;
    EXPECT_EQ(shown.state(10, 10), DepthState::kMeasured);
  }
  const RgbdFrame shown = show(frame);
  EXPECT_EQ(shown.depth(10, 10), 0) << "but not for ever";
  EXPECT_EQ(shown.state(10, 10), DepthState::kHole);
}

TEST_F(TemporalFilterTest, LetsGoOfDepthBesideWhatMoves) {
  show_wall(3);
  RgbdFrame frame = wall();
  set_hole(frame, 10, 10);
  set_hole(frame, 50, 40);
  for (int y = 0; y < 8; ++y) {  // the block to the right of the block with the first hole
    for (int x = 16; x < 24; ++x) (*frame.color)(x, y) = {20, 20, 20};
  }
  const RgbdFrame shown = show(frame);
  EXPECT_EQ(shown.depth(10, 10), 0);
  EXPECT_EQ(shown.depth(50, 40), kWall) << "far from it nothing moves";
}

TEST_F(TemporalFilterTest, CountsFramesThatWereLeftOut) {
  show_wall(3);
  RgbdFrame frame = wall();
  frame.metadata.sequence = 1;
  set_hole(frame, 10, 10);
  EXPECT_EQ(show(frame).depth(10, 10), kWall);
  frame.metadata.sequence += TemporalFilter::kKeptFrames;
  EXPECT_EQ(show(frame).depth(10, 10), kWall);
  ++frame.metadata.sequence;
  EXPECT_EQ(show(frame).depth(10, 10), 0);
}

TEST_F(TemporalFilterTest, PrefersWhatWasMeasuredToWhatIsFilled) {
  show_wall(3);
  RgbdFrame frame = wall();
  frame.depth(10, 10) = 2500;
  frame.state(10, 10) = DepthState::kFilled;
  EXPECT_EQ(show(frame).depth(10, 10), kWall);
  RgbdFrame measured = wall();
  TemporalFilter other;
  other.apply(frame, DepthUnit::kMillimetre, kKinectV1Noise);
  other.apply(measured, DepthUnit::kMillimetre, kKinectV1Noise);
  EXPECT_EQ(measured.depth(10, 10), kWall) << "which a measurement replaces at once";
  EXPECT_EQ(measured.state(10, 10), DepthState::kMeasured);
}

TEST_F(TemporalFilterTest, AsksALoneJumpToConfirmItself) {
  show_wall(3);
  RgbdFrame frame = wall();
  frame.depth(10, 10) = 2000;
  EXPECT_EQ(show(frame).depth(10, 10), kWall);
  EXPECT_EQ(show(frame).depth(10, 10), 2000);
}

TEST_F(TemporalFilterTest, KeepsNothingWhileTheCameraMoves) {
  show_wall(5);
  RgbdFrame frame = wall(2600, {30, 200, 90});
  set_hole(frame, 10, 10);
  const RgbdFrame shown = show(frame);
  EXPECT_EQ(shown.depth, frame.depth);
  EXPECT_EQ(shown.color, frame.color);
}

TEST_F(TemporalFilterTest, KeepsAgainOnceTheCameraStands) {
  show_wall(10);
  for (int i = 1; i <= 5; ++i) show(wall(static_cast<std::uint16_t>(kWall - 150 * i)));
  const auto z = static_cast<std::uint16_t>(kWall - 150 * 5);
  show(wall(z));
  RgbdFrame frame = wall(z);
  set_hole(frame, 10, 10);
  EXPECT_EQ(show(frame).depth(10, 10), z);
  std::minstd_rand random(1);
  for (int i = 0; i < 20; ++i) show(noisy_wall(random));
  const RgbdFrame before = show(noisy_wall(random)), after = show(noisy_wall(random));
  EXPECT_NEAR(before.depth(40, 30), after.depth(40, 30), 13);
}

TEST_F(TemporalFilterTest, HolesAreExactlyWhereThereIsNoDepth) {
  std::minstd_rand random(3);
  std::bernoulli_distribution lost(0.2);
  for (int i = 0; i < 40; ++i) {
    RgbdFrame frame = noisy_wall(random);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (lost(random)) set_hole(frame, x, y);
      }
    }
    frame = show(frame);
    for (std::size_t p = 0; p < frame.depth.pixels().size(); ++p)
      ASSERT_EQ(frame.depth.data()[p] == 0, frame.state.data()[p] == DepthState::kHole);
  }
}

TEST_F(TemporalFilterTest, TakesOddShapesAndFramesWithoutColour) {
  for (const auto& [width, height] : {std::pair{2, 2}, std::pair{70, 50}, std::pair{13, 9}}) {
    for (int i = 0; i < 3; ++i) {
      RgbdFrame frame;
      frame.depth = DepthImage(width, height, 1000);
      frame.state = StateImage(width, height, DepthState::kFilled);
      EXPECT_EQ(show(frame).depth, frame.depth);
    }
  }
}

}  // namespace
}  // namespace copresence::decoding
