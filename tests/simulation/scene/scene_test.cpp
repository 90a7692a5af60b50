#include "simulation/scene/scene.h"

#include <gtest/gtest.h>

#include "simulation/scene/calibration_worlds.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

TEST(Scene, RefusesAnUnknownWorldAndNamesTheKnownOnes) {
  const auto world = make_scene("moon");
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().code, ErrorCode::kInvalid);
  EXPECT_NE(world.error().what.find("room"), std::string::npos);
}

TEST(Scene, MakesEveryWorld) {
  for (const std::string& name : world_names()) EXPECT_TRUE(LitScene::of_world(name)) << name;
}

TEST(Scene, TheMovingBoardFacesTheFirstCameraAndRestsInEachPose) {
  Scene scene;
  const Figure board = make_moving_board(scene);
  const Rigid3 camera_from_world = kinect_poses(1).front().inverse();
  const CameraModel model = kinect_model(640, 480);
  for (int place = 0; place < 24; ++place) {
    const Eigen::Isometry3f world_from_board = board.pose((place + 0.1) / 24).front();
    EXPECT_TRUE(world_from_board.isApprox(board.pose((place + 0.9) / 24).front())) << place;
    const Eigen::Vector3d towards =
        camera_from_world.rotation * world_from_board.linear().col(2).cast<double>();
    EXPECT_GT(towards.z(), 0.7) << place;
    for (const Vertex& vertex : board.parts[1].vertices) {  // the squares
      const Eigen::Vector2d pixel =
          project(model, camera_from_world * (world_from_board * vertex.position).cast<double>());
      EXPECT_TRUE(pixel.x() > 0 && pixel.x() < 639 && pixel.y() > 0 && pixel.y() < 479) << place;
    }
  }
}

TEST(Scene, PhasesOfARecordingCloseWhateverItsLength) {
  for (const std::uint64_t frames : {1u, 7u, 45u, 60u, 90u, 100u, 180u, 601u}) {
    EXPECT_EQ(phase_of_frame(0, frames), 0);
    EXPECT_EQ(phase_of_frame(frames, frames), 0);
    for (std::uint64_t i = 0; i < frames; ++i) {
      ASSERT_GE(phase_of_frame(i, frames), 0);
      ASSERT_LT(phase_of_frame(i, frames), 1);
    }
    if (frames < 30) continue;
    const double step = phase_of_frame(1, frames) * kPeriodFrames;  // 1: the speed of the figure
    EXPECT_GT(step, 0.6) << frames;
    EXPECT_LT(step, 1.7) << frames;
  }
}

TEST(Scene, TheFigureMovesSmoothlyAndPeriodically) {
  Scene scene;
  const Figure person = make_person(scene);
  ASSERT_EQ(person.parts.size(), person.capsules.size());
  auto before = person.pose(0);
  for (int frame = 1; frame <= kPeriodFrames; ++frame) {
    const auto now = person.pose(static_cast<double>(frame) / kPeriodFrames);
    for (std::size_t part = 0; part < now.size(); ++part) {
      EXPECT_LT((now[part].translation() - before[part].translation()).norm(), 0.08f);
      EXPECT_NEAR(now[part].linear().determinant(), 1, 1e-4);
    }
    before = now;
  }
  const auto first = person.pose(0), last = person.pose(1);
  for (std::size_t part = 0; part < first.size(); ++part)
    EXPECT_TRUE(first[part].isApprox(last[part], 1e-5f));
}

TEST(Scene, TheFigureStandsOnTheFloorAndIsAsTallAsAPerson) {
  Scene scene;
  const Figure person = make_person(scene);
  for (const double phase : {0.0, 0.2, 0.5, 0.8}) {
    const auto pose = person.pose(phase);
    float top = 0, bottom = -10;
    for (std::size_t part = 0; part < pose.size(); ++part) {
      for (const Vertex& vertex : person.parts[part].vertices) {
        const float y = (pose[part] * vertex.position).y();
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
    }
    EXPECT_NEAR(bottom, 0, 0.01);
    EXPECT_NEAR(top, -1.78, 0.08);
  }
}

}  // namespace
}  // namespace copresence::simulation
