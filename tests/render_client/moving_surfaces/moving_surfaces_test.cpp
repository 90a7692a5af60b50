// Two cameras look at an arm that moves before a wall. The second camera takes its picture a moment
// later, when the arm is farther to the right.

#include "render_client/moving_surfaces/moving_surfaces.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/render_client/renderer/rendering.h"

namespace copresence::moving_surfaces {
namespace {

using renderer::Looking;
using renderer::Surface;

constexpr int kWidth = 480, kHeight = 270;
constexpr double kArmM = 1.5, kWallM = 3, kArmWidthM = 0.1, kMotionM = 0.06;
constexpr Rgb8 kArmColor{220, 40, 30}, kWallColor{60, 120, 180};

// What a camera at (x_m, 0, z_m) sees of an upright arm with its left side at `arm_m`.
Surface arm_and_wall(double arm_m, double x_m, double z_m = 0) {
  return [=](double x, double) -> std::optional<double> {
    const double at = x_m + x * (kArmM - z_m);
    return (at >= arm_m && at < arm_m + kArmWidthM ? kArmM : kWallM) - z_m;
  };
}

Looking looking(const Surface& surface, double x_m, double z_m = 0) {
  Rigid3 pose;
  pose.translation = {x_m, 0, z_m};
  Looking camera(renderer::kinect_model(), surface, renderer::plain(kWallColor), pose);
  for (std::size_t i = 0; i < camera.frame.depth.pixels().size(); ++i) {
    if (camera.frame.depth.data()[i] < (kWallM - z_m) * 1e4 - 5000) camera.frame.color->data()[i] = kArmColor;
  }
  return camera;
}

// Blocks around everything nearer than the wall.
MovingBlocks moving_blocks(const DepthImage& depth, double wall_m) {
  const int shift = block_shift(depth.width()), size = 1 << shift;
  MovingBlocks moving(depth.width() >> shift, depth.height() >> shift);
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      if (depth(x, y) > wall_m * 1e4 - 5000) continue;
      for (const int beside : {std::max(x - size, 0), x, std::min(x + size, depth.width() - 1)})
        moving(beside >> shift, y >> shift) = 1;
    }
  }
  return moving;
}

class TwoCameras : public ::testing::Test {
 protected:
  TwoCameras() { see(arm_and_wall(-kMotionM, -0.4), arm_and_wall(0, 0.4)); }

  void see(const Surface& left, const Surface& right, double right_z_m = 0) {
    cameras_.clear();
    cameras_.push_back(looking(left, -0.4));
    cameras_.push_back(looking(right, 0.4, right_z_m));
    moving_ = {moving_blocks(cameras_[0].frame.depth, kWallM),
               moving_blocks(cameras_[1].frame.depth, kWallM - right_z_m)};
  }

  // The camera's frame is new.
  void arrive(std::size_t camera) {
    std::vector<std::optional<CameraMotion>> motions;
    for (std::size_t i = 0; i < 2; ++i) {
      motions.push_back(CameraMotion{cameras_[i].view, &moving_[i]});
      motions.back()->view.frame = &cameras_[i].frame;
    }
    surfaces_.leave_out(cameras_[camera].frame, camera, motions);
  }

  int left_out(std::size_t camera) const {
    const RgbdFrame& frame = cameras_[camera].frame;
    int count = 0;
    for (std::size_t i = 0; i < frame.depth.pixels().size(); ++i)
      count += frame.depth.data()[i] == 0 && frame.state.data()[i] != DepthState::kHole;
    return count;
  }
  int arm_pixels(std::size_t camera) const {
    const auto depths = cameras_[camera].frame.depth.pixels();
    return int(std::count_if(depths.begin(), depths.end(),
                             [](std::uint16_t depth) { return depth > 0 && depth < kArmM * 1e4 + 5000; }));
  }

  // The number of pixels in the middle rows of a view from between the cameras that show the arm.
  int shown_arm(const std::vector<Looking*>& cameras) {
    const renderer::MergedView view = renderer::render(cameras, renderer::eye_at_origin(kWidth, kHeight));
    int count = 0;
    renderer::for_each_shown(view, [&](int x, int y) {
      count += std::abs(y - kHeight / 2) < 80 && view.color(x, y).r > view.color(x, y).b;
    });
    return count;
  }
  std::vector<Looking*> both() { return {&cameras_[0], &cameras_[1]}; }

  std::vector<Looking> cameras_;
  std::vector<MovingBlocks> moving_;
  MovingSurfaces surfaces_{2};
};

// A few pixels beside the arm of the better camera stay, since depth edges are inaccurate.
TEST(CaptureTogether, WhateverFramesAreCompared) {
  using std::chrono::milliseconds;
  const Instant start{};
  const double period_s = 0.0333;
  EXPECT_TRUE(capture_together(start, start + milliseconds(3), period_s));
  EXPECT_TRUE(capture_together(start + milliseconds(3), start, period_s));
  EXPECT_TRUE(capture_together(start, start + milliseconds(32), period_s)) << "the next frame is 1 ms away";
  EXPECT_FALSE(capture_together(start, start + milliseconds(17), period_s)) << "half a period";
  EXPECT_FALSE(capture_together(start, start + milliseconds(7), period_s));
}

TEST_F(TwoCameras, ShowAMovingArmOnce) {
  const int alone = shown_arm({&cameras_[0]});
  ASSERT_GT(alone, 1000);
  EXPECT_GT(shown_arm(both()), 1.5 * alone);
  arrive(1);
  EXPECT_NEAR(shown_arm(both()), alone, 0.2 * alone);
}

TEST_F(TwoCameras, ShowAMovingArmOnceAfterTheBetterCamerasNextFrame) {
  arrive(1);
  cameras_[0] = looking(arm_and_wall(kMotionM, -0.4), -0.4);
  moving_[0] = moving_blocks(cameras_[0].frame.depth, kWallM);
  const int alone = shown_arm({&cameras_[0]});
  ASSERT_GT(alone, 1000);
  arrive(0);
  EXPECT_EQ(left_out(0), 0);
  EXPECT_NEAR(shown_arm(both()), alone, 0.2 * alone);
}

TEST_F(TwoCameras, ShowTheWallBesideAMovingArmAsUsual) {
  const DepthImage before = cameras_[1].frame.depth;
  arrive(1);
  ASSERT_GT(left_out(1), 1000);
  for (std::size_t i = 0; i < before.pixels().size(); ++i) {
    if (before.data()[i] < kWallM * 1e4 - 5000) continue;
    ASSERT_EQ(cameras_[1].frame.depth.data()[i], before.data()[i]) << i;
    ASSERT_EQ(cameras_[1].frame.state.data()[i], DepthState::kMeasured) << i;
  }
}

TEST_F(TwoCameras, ShowStillSurfacesAsUsual) {
  moving_ = {{}, {}};
  const RgbdFrame before = cameras_[1].frame;
  arrive(1);
  EXPECT_EQ(cameras_[1].frame.depth, before.depth);
  EXPECT_EQ(cameras_[1].frame.state, before.state);
}

// A post stands before the left camera, between it and the arm.
TEST_F(TwoCameras, KeepWhatTheBetterCameraDoesNotSee) {
  const Surface arm = arm_and_wall(-kMotionM, -0.4);
  see([arm](double x, double y) -> std::optional<double> { return x > 0.2 && x < 0.35 ? 0.8 : arm(x, y); },
      arm_and_wall(0, 0.4));
  const int arm_before = arm_pixels(1);
  arrive(1);
  EXPECT_EQ(left_out(1), 0);
  EXPECT_EQ(arm_pixels(1), arm_before);
}

TEST_F(TwoCameras, KeepWhatTheBetterCameraHasNoDepthFor) {
  for (std::size_t i = 0; i < cameras_[0].frame.depth.pixels().size(); ++i) {
    cameras_[0].frame.depth.data()[i] = 0;
    cameras_[0].frame.state.data()[i] = DepthState::kHole;
  }
  arrive(1);
  EXPECT_EQ(left_out(1), 0);
}

TEST_F(TwoCameras, KeepTheirOrderUntilTheOtherIsClearlyBetter) {
  // The right camera is a little nearer to the arm.
  constexpr double kLittle = 0.1, kMuch = 0.3;
  static_assert(kArmM * kArmM < MovingSurfaces::kSwitch * (kArmM - kLittle) * (kArmM - kLittle));
  static_assert(kArmM * kArmM > MovingSurfaces::kSwitch * (kArmM - kMuch) * (kArmM - kMuch));
  const auto see_from = [&](double right_z_m) {
    see(arm_and_wall(-kMotionM, -0.4), arm_and_wall(0, 0.4, right_z_m), right_z_m);
  };
  for (int frame = 0; frame < 3; ++frame) {
    see_from(kLittle);
    arrive(1);
    EXPECT_GT(left_out(1), 1000);
  }
  see_from(kMuch);
  arrive(1);
  EXPECT_EQ(left_out(1), 0);
  for (int frame = 0; frame < 3; ++frame) {
    see_from(kLittle);
    arrive(0);
    EXPECT_GT(left_out(0), 1000);
    arrive(1);
    EXPECT_EQ(left_out(1), 0);
  }
}

TEST_F(TwoCameras, ShowAWholeArmWhileTheirOrderChanges) {
  arrive(1);
  ASSERT_GT(left_out(1), 1000);
  see(arm_and_wall(-kMotionM, -0.4), arm_and_wall(0, 0.4, 0.3), 0.3);
  arrive(1);
  EXPECT_EQ(left_out(1), 0);
  const int alone = shown_arm({&cameras_[1]});
  arrive(0);
  EXPECT_GT(left_out(0), 1000);
  EXPECT_NEAR(shown_arm(both()), alone, 0.2 * alone);
}

}  // namespace
}  // namespace copresence::moving_surfaces
