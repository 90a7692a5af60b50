#include "capture_server/temporal_filter/depth_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace copresence::temporal_filter {
namespace {

constexpr int kWidth = 160, kHeight = 120;
constexpr int kPixels = kWidth * kHeight;
constexpr double kWall = 3000;  // In mm. A disparity step is 25.6 mm there.
constexpr double kStep = 25.6;

struct Frame {
  DepthImage depth{kWidth, kHeight};
  StateImage state{kWidth, kHeight, DepthState::kMeasured};

  void set(int x, int y, std::uint16_t z) {
    depth(x, y) = z;
    state(x, y) = z ? DepthState::kMeasured : DepthState::kHole;
  }
  void fill(int left, int top, int right, int bottom, std::uint16_t z) {
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) set(x, y, z);
    }
  }
};

/// Returns the depth level that a Kinect reports for depth `z` with noise, in mm.
std::uint16_t measure(double z, std::minstd_rand& random) {
  std::normal_distribution<double> noise(0, kKinectV1Noise.sigma_steps);
  const double constant = 1000 * kKinectV1Noise.disparity_constant_m;
  return static_cast<std::uint16_t>(std::lround(constant / std::round(constant / z + noise(random))));
}

/// A room with a tilted wall and posts in front of it, shifted sideways by `shift` pixels.
Frame room(int shift, std::minstd_rand& random) {
  Frame frame;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int there = x + shift;
      const bool post = there % 20 < 7;
      frame.set(x, y, measure(post ? 1500 + 2 * y : 2500 + 5 * (there % 100) + 4 * y, random));
    }
  }
  return frame;
}

class DepthFilterTest : public ::testing::Test {
 protected:
  Frame show(Frame frame) {
    filter_.apply(frame.depth, frame.state);
    return frame;
  }
  Frame show_noise(double z, int frames) {
    Frame shown;
    for (int i = 0; i < frames; ++i) shown = show(noisy(z));
    return shown;
  }
  Frame noisy(double z) {
    Frame frame;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) frame.set(x, y, measure(z, random_));
    }
    return frame;
  }

  std::minstd_rand random_{1};
  DepthFilter filter_{kWidth, kHeight, DepthUnit::kMillimetre, kKinectV1Noise};
};

int changed_pixels(const DepthImage& a, const DepthImage& b) {
  int changed = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) changed += a.data()[i] != b.data()[i];
  return changed;
}

double rmse(const DepthImage& depth, double truth) {
  double squares = 0;
  for (const std::uint16_t z : depth.pixels()) squares += (z - truth) * (z - truth);
  return std::sqrt(squares / static_cast<double>(depth.pixels().size()));
}

TEST_F(DepthFilterTest, PassesTheFirstFrameUnchanged) {
  const Frame frame = noisy(kWall), shown = show(frame);
  EXPECT_EQ(shown.depth, frame.depth);
  EXPECT_EQ(shown.state, frame.state);
}

TEST_F(DepthFilterTest, HoldsAStillNoisyPlaneStill) {
  for (const double z : {kWall, kWall + kStep / 2, 1200.0}) {
    filter_ = DepthFilter(kWidth, kHeight, DepthUnit::kMillimetre, kKinectV1Noise);
    Frame before = show_noise(z, 30);
    int changed = 0;
    for (int i = 0; i < 10; ++i) {
      const Frame after = show(noisy(z));
      changed += changed_pixels(before.depth, after.depth);
      before = after;
    }
    EXPECT_GT(changed_pixels(noisy(z).depth, noisy(z).depth), kPixels * 2 / 5) << "as it comes";
    EXPECT_LT(changed, 10 * kPixels * 3 / 100)
        << "three pixels in a hundred in each frame, at " << z << " mm";
    EXPECT_LT(rmse(before.depth, z), 0.8 * rmse(noisy(z).depth, z)) << "the nearest level, most of the time";
  }
}

TEST_F(DepthFilterTest, ShowsOnlyLevelsOfTheSensor) {
  const Frame shown = show_noise(kWall, 30);
  for (const std::uint16_t z : shown.depth.pixels()) {
    const double steps = 1000 * kKinectV1Noise.disparity_constant_m / z;
    ASSERT_NEAR(steps, std::round(steps), 0.03) << z;
  }
}

TEST_F(DepthFilterTest, ShowsAHandAtOnceAndThatItIsGone) {
  const Frame still = show_noise(kWall, 30);
  Frame hand = noisy(kWall);
  hand.fill(33, 21, 60, 50, 1500);
  const Frame shown = show(hand);
  for (int y = 21; y < 50; ++y) {
    for (int x = 33; x < 60; ++x) ASSERT_EQ(shown.depth(x, y), 1500) << x << ' ' << y;
  }
  EXPECT_LT(changed_pixels(shown.depth, still.depth), 1.1 * 27 * 29) << "the wall beside it stays still";
  const Frame gone = show(noisy(kWall));
  for (const std::uint16_t z : gone.depth.pixels()) ASSERT_NEAR(z, kWall, 5 * kStep);
}

TEST_F(DepthFilterTest, NeverHidesAHandThatWavesOverTheSamePlace) {
  show_noise(kWall, 30);
  for (int frame = 0; frame < 120; ++frame) {
    Frame waving = noisy(kWall);
    const bool there = frame % 6 < 3;
    if (there) waving.fill(32, 24, 56, 48, 1500);
    const Frame shown = show(waving);
    for (int y = 24; y < 48; ++y) {
      for (int x = 32; x < 56; ++x) ASSERT_EQ(shown.depth(x, y) < 2000, there) << "frame " << frame;
    }
  }
}

TEST_F(DepthFilterTest, ShowsAChangeOfTwoStepsInTheSameFrame) {
  show_noise(kWall, 30);
  Frame frame = noisy(kWall);
  for (int y = 32; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) frame.set(x, y, measure(kWall - 2 * kStep, random_));
  }
  const Frame shown = show(frame);
  double mean = 0;
  for (int y = 32; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) mean += shown.depth(x, y) / (32.0 * 32.0);
  }
  EXPECT_NEAR(mean, kWall - 2 * kStep, 0.2 * kStep);
}

// For example, a door is opened slowly.
TEST_F(DepthFilterTest, FollowsASlowApproachWithoutDelay) {
  for (const double steps_a_frame : {0.02, 0.05, 0.1, 0.3, 1.0}) {
    filter_ = DepthFilter(kWidth, kHeight, DepthUnit::kMillimetre, kKinectV1Noise);
    show_noise(kWall, 30);
    double worst = 0;
    for (int i = 1; i <= 40; ++i) {
      const double z = 1 / (1 / kWall + i * steps_a_frame / (1000 * kKinectV1Noise.disparity_constant_m));
      Frame frame = noisy(kWall);
      for (int y = 24; y < 72; ++y) {
        for (int x = 40; x < 88; ++x) frame.set(x, y, measure(z, random_));
      }
      const Frame shown = show(frame);
      double mean = 0;
      for (int y = 24; y < 72; ++y) {
        for (int x = 40; x < 88; ++x) mean += shown.depth(x, y) / (48.0 * 48.0);
      }
      worst = std::max(worst, std::abs(mean - z) / (1000 * kKinectV1Noise.step_m(z / 1000)));
    }
    EXPECT_LT(worst, 0.65) << steps_a_frame << " steps a frame";
  }
}

TEST_F(DepthFilterTest, AMovingCameraPassesUnchangedFromItsFirstFrame) {
  for (int i = 0; i < 30; ++i) show(room(0, random_));
  EXPECT_FALSE(filter_.is_camera_moving());
  for (int i = 1; i <= 30; ++i) {
    const Frame frame = room(2 * i, random_), shown = show(frame);
    ASSERT_EQ(shown.depth, frame.depth) << i;
    ASSERT_EQ(shown.state, frame.state) << i;
    ASSERT_TRUE(filter_.is_camera_moving());
  }
}

TEST_F(DepthFilterTest, HoldsAgainOnceTheCameraStands) {
  for (int i = 0; i < 10; ++i) show(room(2 * i, random_));
  for (int i = 0; i < CameraMotion::kStillFrames; ++i) show(room(18, random_));
  EXPECT_FALSE(filter_.is_camera_moving());
  Frame before;
  for (int i = 0; i < 30; ++i) before = show(room(18, random_));
  EXPECT_LT(changed_pixels(before.depth, show(room(18, random_)).depth), kPixels / 50);
}

TEST_F(DepthFilterTest, SomebodyInHalfOfThePictureIsNoMovingCamera) {
  for (int i = 0; i < 30; ++i) show(room(0, random_));
  for (int i = 1; i <= 20; ++i) {
    Frame frame = room(0, random_);
    frame.fill(40 + i, 0, 120 + i, kHeight, static_cast<std::uint16_t>(1200 - 10 * i));
    show(frame);
    ASSERT_FALSE(filter_.is_camera_moving());
  }
}

TEST_F(DepthFilterTest, TheMaskDoesNotFlicker) {
  std::bernoulli_distribution rarely(0.3);
  const auto flickering = [&] {
    Frame frame = noisy(kWall);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool mostly_hole = x % 32 < 4, sometimes_hole = x % 32 >= 16 && x % 32 < 20;
        if (mostly_hole || sometimes_hole)
          frame.set(x, y, rarely(random_) == mostly_hole ? frame.depth(x, y) : 0);
      }
    }
    return frame;
  };
  const auto flips = [](const StateImage& a, const StateImage& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) count += a.data()[i] != b.data()[i];
    return count;
  };
  Frame before;
  for (int i = 0; i < 60; ++i) before = show(flickering());
  int shown = 0, as_it_comes = 0;
  for (int i = 0; i < 20; ++i) {
    const Frame after = show(flickering());
    shown += flips(before.state, after.state);
    as_it_comes += flips(flickering().state, flickering().state);
    before = after;
  }
  EXPECT_LT(shown, as_it_comes / 25);
  EXPECT_EQ(before.state(17, 60), DepthState::kMeasured) << "seen most of the time";
}

TEST_F(DepthFilterTest, AHoleAppearsWhereSomebodyStandsUp) {
  for (int i = 0; i < 30; ++i) {
    Frame frame = noisy(kWall);
    frame.fill(40, 30, 90, 100, 1500);
    show(frame);
  }
  Frame empty = noisy(kWall);
  empty.fill(40, 30, 90, 100, 0);
  Frame shown = show(empty);
  int ghosts = 0;
  for (const std::uint16_t z : shown.depth.pixels()) ghosts += z == 1500;
  EXPECT_EQ(ghosts, 0) << "nothing of the person is left";
  for (int y = 32; y < 96; ++y) {
    for (int x = 40; x < 88; ++x) ASSERT_EQ(shown.depth(x, y), 0);
  }
  for (int i = 0; i < DepthFilter::kStateFrames; ++i) shown = show(empty);
  EXPECT_EQ(shown.state, empty.state);
}

TEST_F(DepthFilterTest, HolesAreExactlyWhereThereIsNoDepth) {
  std::bernoulli_distribution lost(0.2);
  for (int i = 0; i < 60; ++i) {
    Frame frame = noisy(kWall);
    frame.fill(2 * i, 20, 2 * i + 30, 100, 1500);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (lost(random_)) frame.set(x, y, 0);
      }
    }
    frame = show(frame);
    for (std::size_t p = 0; p < kPixels; ++p)
      ASSERT_EQ(frame.depth.data()[p] == 0, frame.state.data()[p] == DepthState::kHole);
  }
}

TEST_F(DepthFilterTest, TakesAnyEvenSize) {
  for (const auto& [width, height] : {std::pair{2, 2}, std::pair{70, 50}, std::pair{14, 10}}) {
    DepthFilter filter(width, height, DepthUnit::k100Micrometres, kKinectV1Noise);
    for (const int z : {40000, 30000, 30000, 40000}) {
      const DepthImage frame(width, height, static_cast<std::uint16_t>(z));
      DepthImage depth = frame;
      StateImage state(width, height, DepthState::kFilled);
      filter.apply(depth, state);
      EXPECT_EQ(depth, frame);
    }
  }
}

}  // namespace
}  // namespace copresence::temporal_filter
