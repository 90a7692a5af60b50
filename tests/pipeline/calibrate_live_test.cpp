// calibrate on running servers instead of recordings: the same markers, found through codec and wire.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "common/scene/scene.h"
#include "tests/pipeline/running_room.h"
#include "tests/support/process.h"

namespace copresence::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Ended {
  std::optional<int> code;
  std::string words;
};

Ended run(const std::vector<std::string>& arguments, std::chrono::seconds limit = std::chrono::seconds(60)) {
  Process process(arguments);
  const auto code = process.wait(limit);
  return {code, process.output()};
}

// Two servers with a room key, on simulated Kinects that see markers.
class CalibrateLive : public ::testing::Test {
 protected:
  void SetUp() override {
    const Ended made = run({program("simulate_kinect"), "markers", "--cameras", "2", "--frames", "20",
                            "--out", folder_ / "room"});
    ASSERT_EQ(made.code, 0) << made.words;
    ASSERT_EQ(run({program("capture_server"), "--make-key", key_}).code, 0);
    for (const std::string name : {"camera0", "camera1"}) {
      const std::size_t server =
          room_.serve(folder_ / ("room/" + name + ".oni"), {"--loop", "--name", name, "--key", key_});
      ASSERT_TRUE(room_.server(server).says(room_.address(server), std::chrono::seconds(20)));
      streams_.insert(streams_.end(), {"--stream", name + "=" + room_.address(server)});
    }
  }

  Ended calibrate(const std::string& verb, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{program("calibrate"), verb};
    arguments.insert(arguments.end(), streams_.begin(), streams_.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  TemporaryFolder folder_;
  std::string key_ = folder_ / "room.key";
  RunningRoom room_;
  std::vector<std::string> streams_;
};

TEST_F(CalibrateLive, FindsKeepsAndJudgesPosesOfRunningServers) {
  const std::string found = folder_ / "found.toml";
  const Ended markers = calibrate("markers", {"--key", key_, "--frames", "20", "--out", found});
  ASSERT_EQ(markers.code, 0) << markers.words;
  const auto truth = scene::load(folder_ / "room/scene.toml"), scene = scene::load(found);
  ASSERT_TRUE(truth && scene);
  EXPECT_EQ(scene->key, key_) << "the next commands need no --key";
  const scene::Camera& camera = *scene->find("camera1");
  EXPECT_EQ(camera.address, room_.address(1));
  EXPECT_EQ(camera.source, "");
  const Rigid3 off = *camera.world_from_camera * truth->find("camera1")->world_from_camera->inverse();
  const Eigen::Vector3d middle(0, -0.9, 0);
  EXPECT_LT((off * middle - middle).norm(), 0.01);
  EXPECT_LT(Eigen::AngleAxisd(off.rotation).angle() * 180 / M_PI, 0.3);

  const std::string refined = folder_ / "refined.toml";
  const Ended refine = calibrate("refine", {"--scene", found, "--out", refined});
  EXPECT_EQ(refine.code, 0) << refine.words;
  EXPECT_THAT(refine.words, HasSubstr("camera1: kept as given"));
  const Ended check = calibrate("check", {"--scene", refined});
  EXPECT_EQ(check.code, 0) << check.words;
  EXPECT_THAT(check.words, HasSubstr("good"));
}

TEST_F(CalibrateLive, AServerThatIsNotThereIsNamedBeforeTheOthersAreLookedAt) {
  const std::string nowhere = "127.0.0.1:" + std::to_string(free_port());
  const Ended ended =
      calibrate("markers", {"--stream", "third=" + nowhere, "--key", key_, "--out", folder_ / "none.toml"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.words, HasSubstr(nowhere + ": connection refused: start a capture_server"));
  EXPECT_THAT(ended.words, Not(HasSubstr("camera0: 10 markers")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.toml"));
}

// A chessboard before a live simulated Kinect, which a file unplugs.
class BoardLive : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(control_) << "";
    server_ = room_.serve("simulated:board?control=" + control_, {"--name", "kinect"});
    ASSERT_TRUE(room_.server(server_).says(room_.address(server_), std::chrono::seconds(20)));
  }

  Ended intrinsics(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        program("calibrate"), "intrinsics", "--stream", "left=" + room_.address(server_),
        "--board-size",       "9x6",        "--square", "40"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  TemporaryFolder folder_;
  std::string control_ = folder_ / "control";
  RunningRoom room_;
  std::size_t server_ = 0;
};

TEST_F(BoardLive, IntrinsicsCountsViewsAloudAndFindsTheLensOfARunningServer) {
  const std::string toml = folder_ / "lab.toml";
  const Ended ended = intrinsics({"--frames", "40", "--pause", "0.25", "--scene-out", toml});
  ASSERT_EQ(ended.code, 0) << ended.words;
  EXPECT_THAT(ended.words, HasSubstr("left: picture 1 of 40: "));
  EXPECT_THAT(ended.words, HasSubstr("board found, view 6"));
  const CameraModel lens = scene::load(toml).value().find("left")->model;
  EXPECT_NEAR(lens.fx, 585, 3);
  EXPECT_NEAR(lens.fy, 585, 3);
  EXPECT_NEAR(lens.cx, 319.5, 1.5);
  EXPECT_NEAR(lens.cy, 239.5, 1.5);
  EXPECT_FALSE(lens.is_distorted());
}

TEST_F(BoardLive, ACameraThatIsUnpluggedMeanwhileIsNamedAndNotWaitedForWithoutEnd) {
  std::filesystem::remove(control_);
  const Ended ended = intrinsics({"--out", folder_ / "left.yaml"});
  EXPECT_EQ(ended.code, 1) << ended.words;
  EXPECT_THAT(ended.words, HasSubstr("sends no pictures: "));
  EXPECT_THAT(ended.words, HasSubstr("unplugged"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "left.yaml"));
}

TEST(CalibrateStreams, AnAddressIsHostAndPort) {
  EXPECT_EQ(run({program("calibrate"), "markers", "--stream", "left=nowhere", "--out", "none"}).code, 2);
}

}  // namespace
}  // namespace copresence::testing
