// calibrate intrinsics as a person calls it, on pictures with a known lens.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/scene/scene.h"
#include "tests/support/process.h"
#include "tests/tools/calibrate/painted_board.h"
#include "tools/calibrate/lens/camera_info.h"

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
  const PaintedCamera camera(kLens);
  for (std::size_t i = 0; i < places().size(); ++i) {
    save(camera.picture({{places()[i], chessboard}}), folder / ("photos/" + std::to_string(10 + i) + ".png"));
  }
  const std::string yaml = folder / "left.yaml", toml = folder / "scene.toml", json = folder / "left.json";
  const Outcome outcome = run({"--images", folder / "photos", "--name", "left", "--board-size", "7x5",
                               "--square", "30", "--out", yaml, "--scene-out", toml, "--json", json});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_THAT(outcome.said, HasSubstr("11 pictures, board found in 11"));
  EXPECT_THAT(outcome.said, HasSubstr("reprojection error"));
  const auto info = load_camera_info(yaml);
  ASSERT_TRUE(info) << info.error().what;
  EXPECT_EQ(info->name, "left");
  EXPECT_NEAR(info->model.fx, kLens.fx, 3);
  const auto scene = scene::load(toml);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->find("left")->model, info->model);
  const auto report = nlohmann::json::parse(std::ifstream(json));
  EXPECT_GE(report["views"].size(), 9u);
  EXPECT_LT(report["rms_px"], 0.25);
}

TEST(CalibrateIntrinsics, SaysWhatIsMissing) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "photos");
  EXPECT_THAT(run({"--images", folder / "photos"}).said, HasSubstr("there are no PNG or JPEG pictures"));
  save(PaintedCamera(kLens).picture({{places()[0], chessboard}}), folder / "photos/1.png");
  const Outcome few = run({"--images", folder / "photos", "--board-size", "7x5"});
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.said, HasSubstr("only 1 different, sharp views"));
  std::ofstream(folder / "photos/2.png") << "no picture";
  EXPECT_THAT(run({"--images", folder / "photos"}).said, HasSubstr("2.png: is no picture"));
  EXPECT_EQ(run({}).exit_code, 1);
  EXPECT_EQ(run({"--images", folder / "photos", "--board-size", "7"}).exit_code, 2);
  EXPECT_EQ(run({"--images", "/nowhere"}).exit_code, 2);
}

}  // namespace
}  // namespace copresence::calibrate
