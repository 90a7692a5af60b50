// Runs calibrate intrinsics --depth-to-color on a recording of a sensor that does not register. It
// has a Kinect's depth of markers with cells of foil, and colour from a camera beside it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "capture_server/recording/oni_writer.h"
#include "common/scene/scene.h"
#include "common/scene/write_scene.h"
#include "simulation/sensor/kinect_depth.h"
#include "tests/support/process.h"
#include "tests/tools/calibrate/painted_planes.h"

namespace copresence::calibrate {
namespace {

using ::testing::HasSubstr;

const CameraModel kDepthIntrinsics{640, 480, 575.8, 575.8, 319.5, 239.5, {}};
const CameraModel kColorIntrinsics{640, 480, 525, 526, 318, 242, {0.08, -0.1, 0.001, 0, 0, 0, 0, 0}};
const Rigid3 kColorFromDepth{
    Eigen::AngleAxisd(0.012, Eigen::Vector3d(1, 2, 0).normalized()).toRotationMatrix(),
    {-0.025, 0.001, -0.003}};

struct Outcome {
  int exit_code = -1;
  std::string said;
};

class DepthToColorProgram : public ::testing::Test {
 protected:
  // Records depth with a Kinect's noise and shadows. With `paper`, dark cells return depth like
  // light ones.
  void record(bool paper) {
    const PaintedCamera eye(kDepthIntrinsics);
    const auto markers = painted_markers(Rigid3{});
    auto blank = markers;
    for (PaintedPlane& plane : blank) {
      plane.gray = [inner = plane.gray](double x, double y) { return inner(x, y) < 0 ? -1 : 230; };
    }
    const DepthImage lit = eye.depth(markers), whole = eye.depth(blank);
    simulation::TrueView view{Image<float>(640, 480), ColorImage(640, 480), Image<float>(640, 480)};
    for (std::size_t i = 0; i < whole.pixels().size(); ++i) {
      view.depth_m.data()[i] = 0.001f * whole.data()[i];
      view.infrared.data()[i] = lit.data()[i] == 0 && !paper ? 0.0f : 0.8f;
    }
    const ColorImage color = PaintedCamera(kColorIntrinsics).picture(painted_markers(kColorFromDepth));
    recording::OniContent content;
    content.camera.name = "left";
    content.camera.model = kDepthIntrinsics;
    content.camera.color = recording::ColorCameraMetadata{kColorIntrinsics, Rigid3{}};
    auto writer = recording::OniWriter::create(recording_, content);
    ASSERT_TRUE(writer) << writer.error().what;
    simulation::KinectNoise noise(kDepthIntrinsics, DepthUnit::kMillimetre, 3, 0);
    simulation::DotImage dots;
    simulation::project_dots(kDepthIntrinsics, view, dots);
    DepthImage depth(640, 480);
    for (int frame = 0; frame < 12; ++frame) {
      noise.add_noise(dots, static_cast<std::uint64_t>(frame), depth.pixels());
      const std::chrono::milliseconds time(33 * frame);
      ASSERT_TRUE(writer->write_depth(time, depth));
      ASSERT_TRUE(writer->write_color(time, color));
    }
    ASSERT_TRUE(writer->finish());
  }

  Outcome run(std::vector<std::string> more) {
    std::vector<std::string> arguments{testing::program("calibrate"), "intrinsics", "--depth-to-color",
                                       "--recording", "left=" + recording_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    testing::Process process(arguments);
    const auto code = process.wait(std::chrono::seconds(60));
    return {code.value_or(-1), process.output()};
  }

  testing::TemporaryFolder folder_;
  std::string recording_ = folder_ / "left.oni";
};

TEST_F(DepthToColorProgram, FindsWhereColourStandsFromFoilMarkersThroughAKinectsNoise) {
  record(false);
  const std::string toml = folder_ / "lab.toml";
  const Outcome outcome = run({"--scene-out", toml});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_THAT(outcome.said, HasSubstr("5 markers"));
  const auto scene = scene::load(toml);
  ASSERT_TRUE(scene) << scene.error().what;
  const scene::Camera& left = *scene->find("left");
  EXPECT_EQ(left.model, kDepthIntrinsics);
  ASSERT_TRUE(left.color);
  EXPECT_EQ(left.color->model, kColorIntrinsics);
  const Rigid3& found = left.color->color_from_depth;
  EXPECT_LT((found.translation - kColorFromDepth.translation).norm(), 0.004);
  for (const double z : {1.0, 1.5, 2.5}) {
    for (const double x : {-0.3, 0.0, 0.3}) {
      const Eigen::Vector3d point = z * Eigen::Vector3d(x, 0.5 * x, 1);
      const Eigen::Vector2d there = project(kColorIntrinsics, kColorFromDepth * point);
      EXPECT_LT((project(kColorIntrinsics, found * point) - there).norm(), 1) << x << " " << z;
    }
  }
}

TEST_F(DepthToColorProgram, MarkersOfPaperAreNotEnough) {
  record(true);
  const Outcome outcome = run({"--scene-out", folder_ / "lab.toml"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("foil"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "lab.toml"));
}

TEST_F(DepthToColorProgram, ASensorThatRegistersNeedsNone) {
  testing::Process made({testing::program("simulate_kinect").string(), "markers", "--cameras", "1",
                         "--frames", "4", "--out", (folder_ / "room").string()});
  ASSERT_EQ(made.wait(std::chrono::seconds(60)).value_or(-1), 0) << made.output();
  recording_ = folder_ / "room/camera0.oni";
  const Outcome outcome = run({"--scene-out", folder_ / "lab.toml"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.said, HasSubstr("registers colour to depth itself"));
}

}  // namespace
}  // namespace copresence::calibrate
