// calibrate refine and check as programs: on two real views of one office, where this machine has them, and on the
// project's own recordings.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "capture_server/recording/oni_writer.h"
#include "common/scene/scene.h"
#include "common/scene/write_scene.h"
#include "tests/support/process.h"
#include "tests/support/real_recordings.h"

namespace copresence::testing {
namespace {

using ::testing::HasSubstr;

struct Ended {
  std::optional<int> code;
  std::string words;
};

Ended calibrate(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program("calibrate"));
  Process process(arguments);
  const auto code = process.wait(std::chrono::seconds(60));
  return {code, process.output()};
}

nlohmann::json read_json(const std::filesystem::path& path) {
  std::ifstream file(path);
  return nlohmann::json::parse(file);
}

double millimetres(const Rigid3& a, const Rigid3& b) {
  return 1000 * (a.translation - b.translation).norm();
}

double degrees(const Rigid3& a, const Rigid3& b) {
  return Eigen::AngleAxisd(a.rotation.transpose() * b.rotation).angle() * 180 / M_PI;
}

/// Two cameras with poses, their recordings, and a folder for what is written.
class Refine : public ::testing::Test {
 protected:
  void use(const scene::Camera& a, const std::string& file_a, const scene::Camera& b,
           const std::string& file_b) {
    scene_.cameras = {a, b};
    recordings_ = {"--recording", a.name + "=" + file_a, "--recording", b.name + "=" + file_b};
  }

  Ended run(const std::string& verb, const std::vector<std::string>& more) {
    const std::string path = folder_ / "in.toml";
    EXPECT_TRUE(scene::save(scene_, path, path));
    std::vector<std::string> arguments{verb, "--scene", path};
    arguments.insert(arguments.end(), recordings_.begin(), recordings_.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return calibrate(arguments);
  }

  Rigid3 refined(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"--out", folder_ / "out.toml", "--json", folder_ / "out.json",
                                       "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended ended = run("refine", arguments);
    EXPECT_EQ(ended.code, 0) << ended.words;
    const auto out = scene::load(folder_ / "out.toml");
    EXPECT_TRUE(out) << ended.words;
    EXPECT_EQ(out->cameras[0].world_from_camera->translation,
              scene_.cameras[0].world_from_camera->translation);
    return *out->cameras[1].world_from_camera;
  }

  bool use_office_views() {
    const auto poses = test::real_recording("office_views.json"),
               a = test::real_recording("office_view_a.oni"), b = test::real_recording("office_view_b.oni");
    if (!poses || !a || !b) return false;
    const nlohmann::json told = read_json(*poses);
    std::vector<scene::Camera> cameras(2);
    for (std::size_t i = 0; i < 2; ++i) {
      cameras[i].name = i ? "b" : "a";
      cameras[i].model = {640,
                          480,
                          told["intrinsics"]["fx"],
                          told["intrinsics"]["fy"],
                          told["intrinsics"]["cx"],
                          told["intrinsics"]["cy"],
                          {}};
      Rigid3 pose;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) pose.rotation(r, c) = told["cameras"][i]["world_from_camera"][r][c];
        pose.translation[r] = told["cameras"][i]["world_from_camera"][r][3];
      }
      cameras[i].world_from_camera = pose;
    }
    use(cameras[0], *a, cameras[1], *b);
    return true;
  }

  void disturb(const Rigid3& pose, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> number;
    const Eigen::Vector3d axis = Eigen::Vector3d::NullaryExpr([&] { return number(random); }).normalized();
    const Eigen::Vector3d way = Eigen::Vector3d::NullaryExpr([&] { return number(random); }).normalized();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(5 * M_PI / 180, axis).toRotationMatrix();
    scene_.cameras[1].world_from_camera = Rigid3{turn * pose.rotation, pose.translation + 0.1 * way};
  }

  TemporaryFolder folder_;
  scene::Scene scene_;
  std::vector<std::string> recordings_;
};

TEST_F(Refine, BringsTheOfficeViewsToOnePlaceFromTenCentimetresAndFiveDegreesOff) {
  if (!use_office_views())
    GTEST_SKIP() << "SKIPPED: the real recordings are not on this machine (set COPRESENCE_RECORDINGS)";
  const Rigid3 known = *scene_.cameras[1].world_from_camera;
  const Rigid3 from_known = refined();
  EXPECT_LT(millimetres(from_known, known), 10);
  EXPECT_LT(degrees(from_known, known), 1);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    disturb(known, seed);
    const Rigid3 from_afar = refined();
    EXPECT_LT(millimetres(from_afar, from_known), 2) << seed;
    EXPECT_LT(degrees(from_afar, from_known), 0.1) << seed;
    const nlohmann::json told = read_json(folder_ / "out.json");
    EXPECT_EQ(told["cameras"][1]["outcome"], "refined");
    EXPECT_LT(told["pairs"][0]["after"]["rms_mm"], told["pairs"][0]["before"]["rms_mm"]);
  }
}

TEST_F(Refine, ChecksSayWhichPoseIsGood) {
  if (!use_office_views())
    GTEST_SKIP() << "SKIPPED: the real recordings are not on this machine (set COPRESENCE_RECORDINGS)";
  const Ended good = run("check", {"--json", folder_ / "check.json"});
  EXPECT_EQ(good.code, 0) << good.words;
  EXPECT_TRUE(read_json(folder_ / "check.json")["good"]);
  disturb(*scene_.cameras[1].world_from_camera, 1);
  const Ended kept = run("check", {"--json", folder_ / "check.json"});
  EXPECT_EQ(kept.code, 1);
  EXPECT_THAT(kept.words, HasSubstr("check.json: exists already and is kept"));
  const Ended bad = run("check", {"--json", folder_ / "check.json", "--overwrite"});
  EXPECT_EQ(bad.code, 1) << bad.words;
  EXPECT_FALSE(read_json(folder_ / "check.json")["good"]);
}

class RefineSimulated : public Refine {
 protected:
  void SetUp() override {
    const auto scene = scene::load(recordings() / "scene.toml");
    ASSERT_TRUE(scene);
    use(scene->cameras[0], recordings() / "camera0.oni", scene->cameras[1], recordings() / "camera1.oni");
  }
};

TEST_F(RefineSimulated, TheProjectsOwnRecordingsEndWhereTheyWereMade) {
  const Rigid3 truth = *scene_.cameras[1].world_from_camera;
  disturb(truth, 1);
  const Ended shown = run("check", {"--picture", folder_ / "check.png"});
  EXPECT_EQ(shown.code, 1) << shown.words;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "check.png"));
  const Rigid3 found = refined({"--picture", folder_ / "refine.png"});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "refine.png"));
  // What counts is where things are seen: the middle of the room, 2.35 m before the camera.
  const Eigen::Vector3d middle(0, -1, 0);
  EXPECT_LT(1000 * (found * (truth.inverse() * middle) - middle).norm(), 12);
  EXPECT_LT(degrees(found, truth), 0.3);
}

TEST_F(RefineSimulated, TellsAnErrorThatIsNoLessThanHalfOfWhatItIsWhereSomebodyMoves) {
  const Rigid3 truth = *scene_.cameras[1].world_from_camera;
  disturb(truth, 1);
  const Rigid3 found = refined();
  const Eigen::Vector3d middle(0, -1, 0);
  const double off_mm = 1000 * (found * (truth.inverse() * middle) - middle).norm();
  EXPECT_GT(2 * read_json(folder_ / "out.json")["cameras"][1]["error_mm"].get<double>(), off_mm);
  EXPECT_THAT(run("refine", {"--out", folder_ / "again.toml"}).words,
              HasSubstr("of its pixels did not keep still; if a person moved"));
}

TEST_F(RefineSimulated, CamerasThatSeeNothingInCommonAreRefused) {
  scene_.cameras[1].world_from_camera->translation += Eigen::Vector3d(20, 0, 0);
  const Ended ended = run("refine", {"--out", folder_ / "out.toml"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.words, HasSubstr("of their surfaces, which is too little"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.toml"));
  EXPECT_EQ(run("check", {}).code, 1);
}

TEST_F(RefineSimulated, ACameraThatMeasuresNothingIsToldToTurnNotToKeepStill) {
  recording::OniContent content;
  content.camera.model = scene_.cameras[1].model;
  content.camera.name = "camera1";
  content.color = std::nullopt;
  auto writer = recording::OniWriter::create(folder_ / "blind.oni", content);
  ASSERT_TRUE(writer) << writer.error().what;
  for (int frame = 0; frame < 3; ++frame) {
    ASSERT_TRUE(writer->write_depth(std::chrono::milliseconds(33 * frame), DepthImage(640, 480, 0)));
  }
  ASSERT_TRUE(writer->finish());
  recordings_.back() = "camera1=" + std::string(folder_ / "blind.oni");
  const Ended ended = run("refine", {"--out", folder_ / "out.toml"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.words, HasSubstr("depth was measured in only 0.0 % of the picture: turn the camera"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.toml"));
}

TEST_F(RefineSimulated, ACameraWithoutAPoseIsSentToTheMarkers) {
  scene_.cameras[1].world_from_camera.reset();
  scene_.cameras[1].name = "unknown";
  const Ended ended = run("refine", {"--out", folder_ / "out.toml"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.words, HasSubstr("has no camera \"camera1\""));
}

}  // namespace
}  // namespace copresence::testing
