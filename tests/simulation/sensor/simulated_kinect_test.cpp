#include "simulation/sensor/simulated_kinect.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace copresence::simulation {
namespace {

std::shared_ptr<const LitScene> room() {
  static const auto kRoom = std::make_shared<const LitScene>(LitScene::of_world("room").value());
  return kRoom;
}

TEST(SimulatedKinect, SeesTheRoomWithAsManyHolesAsARealOne) {
  const auto poses = kinect_poses(2);
  for (std::size_t camera = 0; camera < 2; ++camera) {
    auto kinect =
        SimulatedKinect::make(room(), kinect_model(320, 240), poses, camera, DepthUnit::kMillimetre, 1)
            .value();
    DepthImage depth;
    ColorImage color;
    kinect.capture(0, 0, depth, color);
    const double holes = static_cast<double>(std::count(depth.pixels().begin(), depth.pixels().end(), 0)) /
                         static_cast<double>(depth.pixels().size());
    EXPECT_GT(holes, 0.09);
    EXPECT_LT(holes, 0.21);
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      ASSERT_GT(kinect.truth().depth_m.data()[i], 0);  // a closed room
    }
  }
}

TEST(SimulatedKinect, DeliversTheSameFramesLiveAsRecorded) {
  const auto poses = kinect_poses(2);
  const auto make = [&] {
    return SimulatedKinect::make(room(), kinect_model(160, 120), poses, 0, DepthUnit::kMillimetre, 1).value();
  };
  auto live = make(), traced = make();
  live.precompute();
  DepthImage depth(160, 120), expected_depth;
  ColorImage color(160, 120), expected_color;
  for (const std::uint64_t frame : {7, 8, 30, 31, 67, 68, 127, 7}) {  // some phases twice
    live.capture_live_depth(frame, depth.pixels());
    live.capture_live_color(frame, color.pixels());
    traced.capture(phase_of_frame(frame, kPeriodFrames), frame, expected_depth, expected_color);
    EXPECT_EQ(depth, expected_depth) << frame;
    EXPECT_EQ(color, expected_color) << frame;
  }
}

TEST(SimulatedKinect, DeliversALiveFrameWhateverItDeliveredBefore) {
  const auto live = [] {
    auto made =
        SimulatedKinect::make(room(), kinect_model(160, 120), kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
            .value();
    made.precompute();
    return made;
  };
  auto running = live(), fresh = live();
  const auto depth_of = [](SimulatedKinect& kinect, std::uint64_t frame) {
    DepthImage depth(160, 120, 1);
    kinect.capture_live_depth(frame, depth.pixels());
    return depth;
  };
  const auto color_of = [](SimulatedKinect& kinect, std::uint64_t frame) {
    ColorImage color(160, 120, {1, 2, 3});
    kinect.capture_live_color(frame, color.pixels());
    return color;
  };
  const DepthImage first = depth_of(running, 7), other = depth_of(running, 37);
  EXPECT_NE(first, other);
  EXPECT_NE(color_of(running, 37), color_of(running, 7));
  for (const std::uint64_t frame : {67, 68, 200, 67}) {
    EXPECT_EQ(depth_of(running, frame), depth_of(fresh, frame)) << frame;
    EXPECT_EQ(color_of(running, frame), color_of(fresh, frame)) << frame;
  }
  EXPECT_EQ(depth_of(fresh, 7), first);
}

TEST(SimulatedKinect, GivesTheSameFramesAgain) {
  const auto poses = kinect_poses(2);
  const auto frames = [&](std::uint32_t seed) {
    auto kinect =
        SimulatedKinect::make(room(), kinect_model(160, 120), poses, 1, DepthUnit::kMillimetre, seed).value();
    std::pair<DepthImage, ColorImage> frame;
    for (std::uint64_t i = 0; i < 3; ++i) kinect.capture(phase_of_frame(i, 60), i, frame.first, frame.second);
    return frame;
  };
  EXPECT_EQ(frames(3), frames(3));
  EXPECT_NE(frames(3), frames(4));
}

TEST(SimulatedKinect, StandsInTheRoomAndLooksAtThePerson) {
  for (int count = 1; count <= kMostKinects; ++count) {
    const auto poses = kinect_poses(count);
    ASSERT_EQ(poses.size(), static_cast<std::size_t>(count));
    for (const Rigid3& pose : poses) {
      EXPECT_TRUE(pose.is_rigid());
      EXPECT_LT(pose.rotation.col(1).y(), 1.01);
      EXPECT_GT(pose.rotation.col(1).y(), 0.9);  // upright
      const Eigen::Vector3d chest = pose.inverse() * Eigen::Vector3d(0, -1.2, 0);
      EXPECT_GT(chest.z(), 1.5);
      EXPECT_LT(chest.z(), 2.5);
      const Eigen::Vector2d pixel = project(kinect_model(640, 480), chest);
      EXPECT_NEAR(pixel.x(), 319.5, 5);
      EXPECT_NEAR(pixel.y(), 180, 60);
    }
  }
}

}  // namespace
}  // namespace copresence::simulation
