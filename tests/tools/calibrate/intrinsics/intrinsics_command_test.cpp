// Runs calibrate intrinsics on pictures with known intrinsics.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/scene/scene.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tests/support/process.h"
#include "tests/tools/calibrate/painted_board.h"
#include "tools/calibrate/intrinsics/camera_info.h"

namespace copresence::calibrate {
namespace {

using ::testing::HasSubstr;
using testing::program;

struct Outcome {
  int exit_code = -1;
  std::string said;
};

Outcome run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {program("calibrate").string(), "intrinsics"});
  testing::Process process(arguments);
  const auto code = process.wait(std::chrono::seconds(60));
  return {code.value_or(-1), process.output()};
}

void save(const ColorImage& picture, const std::filesystem::path& file) {
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  cv::imwrite(file.string(), bgr);
}

TEST(CalibrateIntrinsics, WritesOneLensForRosAndForTheScene) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "photos");
  const PaintedCamera camera(kIntrinsics);
  for (std::size_t i = 0; i < places().size(); ++i) {
    save(camera.picture({{places()[i], chessboard}}), folder / ("photos/" + std::to_string(10 + i) + ".png"));
  }
  const std::string yaml = folder / "left.yaml", toml = folder / "scene.toml", json = folder / "left.json";
  const Outcome outcome = run({"--images", folder / "photos", "--name", "left", "--board-size", "7x5",
                               "--square", "30", "--out", yaml, "--scene-out", toml, "--json", json});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_THAT(outcome.said, HasSubstr("11 pictures, board found in 11"));
  EXPECT_THAT(outcome.said, HasSubstr("reprojection error"));
  EXPECT_THAT(outcome.said, HasSubstr("picture 1 of 11, 10.png: board found, view 1"));
  const auto info = load_camera_info(yaml);
  ASSERT_TRUE(info) << info.error().what;
  EXPECT_EQ(info->name, "left");
  EXPECT_NEAR(info->model.fx, kIntrinsics.fx, 3);
  const auto scene = scene::load(toml);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->find("left")->model, info->model);
  const auto report = nlohmann::json::parse(std::ifstream(json));
  EXPECT_GE(report["views"].size(), 9u);
  EXPECT_LT(report["rms_px"], 0.25);

  // Existing files are kept, except the scene file, which is updated.
  const Outcome again =
      run({"--images", folder / "photos", "--board-size", "7x5", "--square", "30", "--out", yaml});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.said,
              HasSubstr("left.yaml: exists already and is kept; give another name or --overwrite"));
  const Outcome replaced =
      run({"--images", folder / "photos", "--name", "left", "--board-size", "7x5", "--square", "30",
           "--scene", toml, "--scene-out", toml, "--out", yaml, "--overwrite"});
  EXPECT_EQ(replaced.exit_code, 0) << replaced.said;
  const Outcome other =
      run({"--images", folder / "photos", "--board-size", "7x5", "--square", "30", "--scene-out", json});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.said, HasSubstr("is no scene file"));
}

TEST(CalibrateIntrinsics, FindsASimulatedKinectsLensFromARecordingAndShowsTheCorners) {
  const testing::TemporaryFolder folder;
  testing::Process made({program("simulate_kinect").string(), "board", "--cameras", "1", "--frames", "24",
                         "--out", (folder / "board").string()});
  ASSERT_EQ(made.wait(std::chrono::seconds(60)).value_or(-1), 0) << made.output();
  const std::string yaml = folder / "camera0.yaml", sheet = folder / "board.jpg";
  const Outcome outcome = run({"--recording", "camera0=" + (folder / "board/camera0.oni").string(),
                               "--board-size", "9x6", "--square", "40", "--out", yaml, "--picture", sheet});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  const CameraModel truth = simulation::kinect_model(640, 480), found = load_camera_info(yaml).value().model;
  EXPECT_NEAR(found.fx, truth.fx, 2);
  EXPECT_NEAR(found.fy, truth.fy, 2);
  for (int y = 40; y < 480; y += 100) {
    for (int x = 40; x < 640; x += 140) {
      const Eigen::Vector3d ray = unproject(truth, {double(x), double(y)}, 1);
      EXPECT_LT((project(found, ray) - Eigen::Vector2d(x, y)).norm(), 3) << x << ", " << y;
    }
  }
  const cv::Mat picture = cv::imread(sheet);
  EXPECT_EQ(picture.cols, 960);
  EXPECT_GT(picture.rows, 300);
}

TEST(CalibrateIntrinsics, TakesALensFromRosIntoTheSceneFile) {
  const testing::TemporaryFolder folder;
  const std::string yaml = folder / "kinect.yaml", toml = folder / "scene.toml", back = folder / "back.yaml";
  ASSERT_TRUE(save_camera_info({"kinect", kIntrinsics}, yaml));
  std::ofstream(folder / "latin1.yaml") << "image_width: 640\nimage_height: 480\ncamera_name: k\xfc"
                                           "che\n"
                                           "k: [525, 4, 320, 0, 525, 240, 0, 0, 1]\nd: []\n";
  const Outcome latin1 = run({"--camera-info", folder / "latin1.yaml", "--scene-out", toml});
  EXPECT_EQ(latin1.exit_code, 1);
  EXPECT_THAT(latin1.said, HasSubstr("\"k?che\" is not UTF-8 text"));
  EXPECT_FALSE(std::filesystem::exists(toml));
  const Outcome named =
      run({"--camera-info", folder / "latin1.yaml", "--name", "room", "--scene-out", folder / "a.toml"});
  EXPECT_EQ(named.exit_code, 0) << named.said;
  EXPECT_THAT(named.said, HasSubstr("a skew of 4"));
  const Outcome depth = run({"--camera-info", yaml, "--scene-out", toml, "--out", back});
  ASSERT_EQ(depth.exit_code, 0) << depth.said;
  EXPECT_EQ(scene::load(toml).value().find("kinect")->model, kIntrinsics);
  EXPECT_EQ(load_camera_info(back).value().model, kIntrinsics);
  CameraModel color = kIntrinsics;
  color.fx = 310;
  ASSERT_TRUE(save_camera_info({"rgb", color}, yaml));
  const Outcome both = run(
      {"--camera-info", yaml, "--color-camera", "--name", "kinect", "--scene", toml, "--scene-out", toml});
  ASSERT_EQ(both.exit_code, 0) << both.said;
  const auto scene = scene::load(toml).value();
  EXPECT_EQ(scene.find("kinect")->model, kIntrinsics);
  EXPECT_EQ(scene.find("kinect")->color->model, color);
  const Outcome idle = run({"--camera-info", yaml});
  EXPECT_EQ(idle.exit_code, 1);
  EXPECT_THAT(idle.said, HasSubstr("give --scene-out as well"));
}

TEST(CalibrateIntrinsics, SaysWhatIsMissing) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "photos");
  EXPECT_THAT(run({"--images", folder / "photos"}).said, HasSubstr("there are no PNG or JPEG pictures"));
  save(PaintedCamera(kIntrinsics).picture({{places()[0], chessboard}}), folder / "photos/1.png");
  const Outcome few = run({"--images", folder / "photos", "--board-size", "7x5"});
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.said, HasSubstr("only 1 different, sharp views"));
  const Outcome wrong_size = run({"--images", folder / "photos", "--board-size", "12x9"});
  EXPECT_THAT(wrong_size.said, HasSubstr("none of 1 pictures shows the whole board (12x9 inner corners); "
                                         "1.png: it shows 7x5 inner corners"));
  std::ofstream(folder / "photos/2.png") << "no picture";
  EXPECT_THAT(run({"--images", folder / "photos"}).said, HasSubstr("2.png: not an image that is read here"));
  const std::string yaml = folder / "nameless.yaml";
  ASSERT_TRUE(save_camera_info({"", kIntrinsics}, yaml));
  const Outcome nameless = run({"--camera-info", yaml, "--scene-out", folder / "scene.toml"});
  EXPECT_EQ(nameless.exit_code, 1);
  EXPECT_THAT(nameless.said, HasSubstr("has no camera_name; name the camera with --name"));
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.toml"));
  const Outcome lost = run({"--images", folder / "photos", "--out", "/nowhere/left.yaml"});
  EXPECT_EQ(lost.exit_code, 2);
  EXPECT_THAT(lost.said, HasSubstr("there is no folder /nowhere"));
  EXPECT_EQ(run({}).exit_code, 1);
  EXPECT_EQ(run({"--images", folder / "photos", "--board-size", "7"}).exit_code, 2);
  EXPECT_EQ(run({"--images", "/nowhere"}).exit_code, 2);
}

}  // namespace
}  // namespace copresence::calibrate
