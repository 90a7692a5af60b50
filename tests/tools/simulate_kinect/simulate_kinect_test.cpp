// The program as a person calls it.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "common/scene/scene.h"

namespace copresence {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code = -1;
  std::string said;  // both streams
};

Outcome run(const std::string& arguments) {
  Outcome outcome;
  std::FILE* pipe = popen(fmt::format("{} {} 2>&1", SIMULATE_KINECT, arguments).c_str(), "r");
  std::array<char, 4096> chunk;
  while (const std::size_t count = std::fread(chunk.data(), 1, chunk.size(), pipe))
    outcome.said.append(chunk.data(), count);
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

class SimulateKinect : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  static std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder_ = fs::temp_directory_path() / ("copresence_simulate_" + std::to_string(getpid()));
};

TEST_F(SimulateKinect, WritesARecordingPerCameraASceneAndTheTruth) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "above.txt") << "0 1 -1.6 -1.8  0 -1 0\n";
  const Outcome outcome = run("room --cameras 2 --frames 2 --size 160x120 --truth-size 64x48 --out " +
                              (folder_ / "a").string() + " --truth " + (folder_ / "above.txt").string());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  const auto scene = scene::load(folder_ / "a" / "scene.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->cameras.size(), 2u);
  for (const auto& camera : scene->cameras) {
    EXPECT_TRUE(fs::exists(camera.source)) << camera.source;
    EXPECT_EQ(camera.model.width, 160);
    ASSERT_TRUE(camera.world_from_camera);
    EXPECT_TRUE(camera.world_from_camera->is_rigid(1e-9));
  }
  EXPECT_EQ(scene->cameras[1].address, "127.0.0.1:7002");
  for (const char* name : {"camera0", "camera1", "above"}) {
    const cv::Mat depth =
        cv::imread((folder_ / "a/truth" / name / "depth_0001.png").string(), cv::IMREAD_UNCHANGED);
    const cv::Mat color = cv::imread((folder_ / "a/truth" / name / "color_0001.png").string());
    ASSERT_EQ(depth.type(), CV_16UC1) << name;
    EXPECT_EQ(color.size(), depth.size());
    const int middle = depth.at<std::uint16_t>(depth.rows / 2, depth.cols / 2);
    EXPECT_GT(middle, 15000);  // 0.1 mm: the person stands at 2 m or so
    EXPECT_LT(middle, 30000);
  }
}

TEST_F(SimulateKinect, WritesTheCamerasTruthWithoutFurtherViewpoints) {
  const Outcome outcome =
      run("markers --cameras 1 --frames 1 --size 64x48 --out " + folder_.string() + " --truth");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.said;
  EXPECT_TRUE(fs::exists(folder_ / "truth/camera0/depth_0000.png"));
  EXPECT_TRUE(scene::load(folder_ / "scene.toml"));
}

TEST_F(SimulateKinect, GivesTheSameBytesForTheSameSeed) {
  const auto recorded = [&](const char* name, int seed) {
    const Outcome outcome = run("room --cameras 1 --frames 2 --size 64x48 --seed " + std::to_string(seed) +
                                " --out " + (folder_ / name).string());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.said;
    return bytes_of(folder_ / name / "camera0.oni");
  };
  const std::string first = recorded("a", 5);
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(first, recorded("b", 5));
  EXPECT_NE(first, recorded("c", 6));
}

TEST_F(SimulateKinect, RefusesWrongCommandLinesWithOneSentenceAndTwo) {
  const std::string out = " --out " + folder_.string();
  for (const std::string& arguments :
       {std::string(""), std::string("room"), "moon" + out, "room --cameras 0" + out,
        "room --cameras 9" + out, "room --frames 0" + out, "room --frames many" + out,
        "room --size 641x480" + out, "room --size large" + out, "room --unit inch" + out,
        "room --seed -1" + out, "room --truth /nowhere/path" + out, "room --surprise" + out}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << '\n' << outcome.said;
    EXPECT_FALSE(outcome.said.empty());
  }
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(SimulateKinect, SaysWhyItCannotWriteAndLeavesWithOne) {
  const Outcome outcome = run("room --frames 1 --out /dev/null/folder");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.said.find("/dev/null/folder"), std::string::npos) << outcome.said;
}

TEST_F(SimulateKinect, KeepsFilesThatExistUnlessToldToOverwriteThem) {
  fs::create_directories(folder_);
  for (const char* name : {"camera0.oni", "scene.toml"}) {
    std::ofstream(folder_ / name) << "old";
    const std::string arguments = "empty-room --cameras 1 --frames 1 --size 32x32 --out " + folder_.string();
    const Outcome kept = run(arguments);
    EXPECT_EQ(kept.exit_code, 1);
    EXPECT_NE(kept.said.find((folder_ / name).string() + ": exists already"), std::string::npos) << kept.said;
    EXPECT_EQ(bytes_of(folder_ / name), "old");
    const Outcome replaced = run(arguments + " --overwrite");
    EXPECT_EQ(replaced.exit_code, 0) << replaced.said;
    EXPECT_NE(bytes_of(folder_ / name), "old");
    fs::remove(folder_ / "camera0.oni");
    fs::remove(folder_ / "scene.toml");
  }
}

TEST_F(SimulateKinect, ExplainsItself) {
  const Outcome help = run("--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* word :
       {"WORLD", "--cameras", "--frames", "--out", "--seed", "--size", "--truth", "0.1 mm"}) {
    EXPECT_NE(help.said.find(word), std::string::npos) << word;
  }
  const Outcome version = run("--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.said.rfind("simulate_kinect ", 0), 0u) << version.said;
}

}  // namespace
}  // namespace copresence
