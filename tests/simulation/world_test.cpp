#include "simulation/world.h"

#include <gtest/gtest.h>

#include "simulation/board_world.h"
#include "simulation/simulated_kinect.h"
#include "tests/simulation/scenes.h"

namespace copresence::simulation {
namespace {

TEST(World, RefusesAnUnknownNameAndSaysWhichThereAre) {
  const auto world = World::make("moon");
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().code, ErrorCode::kInvalid);
  EXPECT_NE(world.error().what.find("room"), std::string::npos);
}

TEST(World, MakesEveryWorldThatItNames) {
  for (const std::string& name : World::names()) EXPECT_TRUE(World::make(name)) << name;
}

TEST(World, AMovingBoardFacesTheFirstCameraAndRestsInEachPlace) {
  Furnishing furnishing;
  const Figure board = make_moving_board(furnishing);
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

TEST(World, PhasesOfARecordingCloseWhateverItsLength) {
  for (const std::uint64_t frames : {1u, 7u, 45u, 60u, 90u, 100u, 180u, 601u}) {
    EXPECT_EQ(phase_of_frame(0, frames), 0);
    EXPECT_EQ(phase_of_frame(frames, frames), 0);
    for (std::uint64_t i = 0; i < frames; ++i) {
      ASSERT_GE(phase_of_frame(i, frames), 0);
      ASSERT_LT(phase_of_frame(i, frames), 1);
    }
    if (frames < 30) continue;
    const double step = phase_of_frame(1, frames) * kPeriodFrames;  // 1: the figure's own speed
    EXPECT_GT(step, 0.6) << frames;
    EXPECT_LT(step, 1.7) << frames;
  }
}

TEST(World, TheFigureMovesSmoothlyAndComesBack) {
  Furnishing furnishing;
  const Figure person = make_person(furnishing);
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

TEST(World, TheFigureStandsOnTheFloorAndIsAsTallAsAPerson) {
  Furnishing furnishing;
  const Figure person = make_person(furnishing);
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

TEST(World, LightFallsOffWithDistanceAndStopsAtSolids) {
  Furnishing furnishing = wall_at(2);
  furnishing.lights = {{{0, 0, 0}, {0.01f, 0, 0}, {0, -0.01f, 0}, {4, 4, 4}}};  // faces +z
  furnishing.meshes.clear();
  furnishing.add(panel({0, 0, 2}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0, 0.1f));
  const auto open = World::of(furnishing).value();
  EXPECT_NEAR(open.light().vertices[0][60].lamp.x(), 1, 0.02);  // 4 / 2^2 in the middle
  furnishing.add(panel({0, 0, 1}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0, 0.5f));
  const auto closed = World::of(furnishing).value();
  EXPECT_EQ(closed.light().vertices[0][60].lamp.x(), 0);
}

TEST(World, CapsulesShadeWhatLiesBehindThem) {
  ShadowPoints points;
  const Eigen::Vector3f lamp(0, -2, 0);
  points.add({0, 0, 0});
  points.add({0.5f, 0, 0});
  points.aim_at(lamp);
  std::vector<float> hidden(2);
  const Capsule bar{{-0.05f, -1, -1}, {-0.05f, -1, 1}, 0.1f};
  shade(points, {&bar, 1}, 0.02f, hidden);
  EXPECT_NEAR(hidden[0], 1, 1e-3);
  EXPECT_NEAR(hidden[1], 0, 1e-3);
}

}  // namespace
}  // namespace copresence::simulation
