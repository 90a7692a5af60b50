// Tests the whole system with real processes. Recordings are the input, a picture and statistics
// the output.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/depth/depth_codec.h"
#include "common/wire/frame_client.h"
#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class Live : public ::testing::Test {
 protected:
  void serve_both(const RunningRoom::Arguments& more = {"--loop"}) {
    for (const char* camera : {"camera0", "camera1"}) {
      RunningRoom::Arguments arguments{"--scene", recordings() / "scene.toml"};
      arguments.insert(arguments.end(), more.begin(), more.end());
      room_.serve(recordings() / (std::string(camera) + ".oni"), arguments);
    }
  }

  RunningRoom room_;
};

/// Share of pixels that are not black.
double shown_share(const std::filesystem::path& picture) {
  const cv::Mat image = cv::imread(picture.string());
  if (image.empty()) return 0;
  cv::Mat lit;
  cv::inRange(image, cv::Scalar(0, 0, 0), cv::Scalar(0, 0, 0), lit);
  return 1.0 - cv::countNonZero(lit) / static_cast<double>(image.total());
}

TEST_F(Live, TwoCamerasBecomeOneView) {
  serve_both();
  const auto stats = room_.view({"--frames", "45", "--size", "640x360"});
  ASSERT_EQ(stats["cameras"].size(), 2u);
  for (int i : {0, 1}) {
    const auto& camera = stats["cameras"][i];
    EXPECT_EQ(camera["name"], "camera" + std::to_string(i));
    EXPECT_GT(camera["frames_received"], 20);
    EXPECT_GE(camera["frames_captured"], camera["frames_received"]);
    EXPECT_GT(camera["mbps"], 0.5);
    EXPECT_GT(camera["latency_ms"]["p50"], 0.0);
    EXPECT_LE(camera["latency_ms"]["p50"], camera["latency_ms"]["p95"]);
    EXPECT_LE(camera["latency_ms"]["p95"], camera["latency_ms"]["p99"]);
    std::uint64_t drops = 0;
    for (const char* cause : {"encoder_busy", "window_full", "decode_error"}) {
      drops += camera["drops"][cause].get<std::uint64_t>();
    }
    EXPECT_EQ(camera["frames_dropped"], drops);
    for (const char* stage :
         {"capture", "fill", "depth_encode", "video_encode", "wire", "video_decode", "depth_decode"}) {
      EXPECT_GT(camera["stages_ms"][stage]["p50"], 0.0) << stage;
      EXPECT_GE(camera["stages_ms"][stage]["p95"], camera["stages_ms"][stage]["p50"]) << stage;
    }
  }
  EXPECT_EQ(stats["view"]["frames"], 45);
  EXPECT_EQ(stats["view"]["size"], "640x360");
  EXPECT_GT(stats["view"]["fps"], 5.0);
  EXPECT_EQ(stats["clock"]["offset_us"], 0.0);  // Client and server use the same clock.
  EXPECT_GT(shown_share(room_.picture()), 0.5);
}

TEST_F(Live, ARecordingEndsTheServerAfterItsLastFrame) {
  serve_both({});
  for (std::size_t i : {0u, 1u}) EXPECT_EQ(room_.server(i).wait(seconds(20)), 0) << room_.server(i).output();
}

TEST_F(Live, FramesEndsTheServerWithoutAnyClient) {
  room_.serve(recordings() / "camera0.oni", {"--frames", "10", "--pace", "fast", "--loop"});
  EXPECT_EQ(room_.server(0).wait(seconds(20)), 0) << room_.server(0).output();
}

TEST_F(Live, EveryCodecShowsTheRoom) {
  std::vector<std::string> codecs(depth::codec_names().begin(), depth::codec_names().end());
  codecs.push_back("triangle:period=0.8");
  for (const std::string& codec : codecs) {
    RunningRoom room;
    room.serve(recordings() / "camera0.oni", {"--loop", "--codec", codec});
    const auto stats = room.view({"--frames", "5", "--size", "320x180"});
    ASSERT_FALSE(stats.is_null()) << codec;
    EXPECT_EQ(stats["cameras"][0]["drops"]["decode_error"], 0) << codec;
    EXPECT_GT(shown_share(room.picture()), 0.3) << codec;
  }
}

TEST_F(Live, EveryHoleFillerShowsTheRoom) {
  for (const char* filler : {"off", "median", "bilateral", "joint"}) {
    RunningRoom room;
    room.serve(recordings() / "camera0.oni", {"--loop", "--hole-filling", filler});
    const auto stats = room.view({"--frames", "5", "--size", "320x180"});
    ASSERT_FALSE(stats.is_null()) << filler;
    EXPECT_GT(shown_share(room.picture()), 0.3) << filler;
  }
}

TEST_F(Live, TheStreamSaysWhetherItIsFilteredOverTime) {
  const auto is_filtered = [](const RunningRoom::Arguments& more) {
    RunningRoom room;
    room.serve(recordings() / "camera0.oni", more);
    for (int tries = 0; tries < 100; ++tries) {
      const auto client = wire::FrameClient::connect(room.address(0), seconds(2), {});
      if (client) return client->description().is_temporally_filtered;
      std::this_thread::sleep_for(milliseconds(100));
    }
    throw std::runtime_error("no server at " + room.address(0));
  };
  EXPECT_TRUE(is_filtered({"--loop"}));
  EXPECT_FALSE(is_filtered({"--loop", "--temporal-filter", "off"}));
  EXPECT_FALSE(is_filtered({"--loop", "--depth-qp", "0"})) << "lossless";
}

TEST_F(Live, BothRenderersShowTheSameRoom) {
  for (const char* renderer : {"cpu", "gl"}) {
    RunningRoom room;
    room.serve(recordings() / "camera0.oni", {"--loop"});
    const auto stats = room.view({"--frames", "3", "--size", "320x180", "--renderer", renderer});
    ASSERT_FALSE(stats.is_null()) << renderer;
    EXPECT_EQ(stats["view"]["renderer"], renderer);
    EXPECT_GT(shown_share(room.picture()), 0.3) << renderer;
  }
}

TEST_F(Live, TheClientWaitsForItsServerAndComesBackToIt) {
  const std::size_t server = room_.serve(recordings() / "camera0.oni", {"--loop"});
  room_.kill_server(server);
  Process& client = room_.look({"--size", "320x180"});
  EXPECT_TRUE(client.says("waiting", seconds(10))) << client.output();
  room_.restart_server(server);
  EXPECT_TRUE(client.says("connected", seconds(10))) << client.output();
  std::this_thread::sleep_for(milliseconds(500));
  room_.kill_server(server);  // Kills the server while it sends.
  EXPECT_EQ(client.wait(milliseconds(700)), std::nullopt);
  room_.restart_server(server);
  std::this_thread::sleep_for(milliseconds(2000));
  client.signal(SIGTERM);
  EXPECT_EQ(client.wait(seconds(1)), 0) << client.output();
  const auto stats = room_.stats();
  ASSERT_FALSE(stats.is_discarded());
  EXPECT_GT(stats["cameras"][0]["frames_received"], 20);
  EXPECT_GT(shown_share(room_.picture()), 0.3);
}

TEST_F(Live, AKilledClientDisturbsNobody) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& victim = room_.look({"--size", "320x180"});
  ASSERT_TRUE(victim.says("connected", seconds(10)));
  Process& other = room_.look({"--size", "320x180", "--frames", "60"});
  ASSERT_TRUE(other.says("connected", seconds(10)));
  victim.signal(SIGKILL);
  EXPECT_EQ(other.wait(seconds(20)), 0) << other.output();
  EXPECT_EQ(room_.stats()["cameras"][0]["drops"]["decode_error"], 0);
}

TEST_F(Live, AClientThatStopsReadingDelaysNobody) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& sleeper = room_.look({"--size", "320x180"});
  ASSERT_TRUE(sleeper.says("connected", seconds(10)));
  std::this_thread::sleep_for(milliseconds(300));
  sleeper.signal(SIGSTOP);
  Process& other = room_.look({"--size", "320x180", "--frames", "90"});
  EXPECT_EQ(other.wait(seconds(20)), 0) << other.output();  // The sleeper delays no frame.
  EXPECT_EQ(room_.stats()["cameras"][0]["drops"]["decode_error"], 0);
  sleeper.signal(SIGCONT);  // The client continues at the next keyframe.
  std::this_thread::sleep_for(milliseconds(1500));
  sleeper.signal(SIGTERM);
  EXPECT_EQ(sleeper.wait(seconds(1)), 0) << sleeper.output();
  const auto drops = room_.stats()["cameras"][0]["drops"];
  EXPECT_GT(drops["window_full"], 10) << drops;
  EXPECT_EQ(drops["decode_error"], 0) << drops;
}

TEST_F(Live, SigtermEndsTheServerWithinASecond) {
  serve_both();
  ASSERT_TRUE(room_.server(0).says("camera0", seconds(10)));
  for (std::size_t i : {0u, 1u}) {
    room_.server(i).signal(SIGTERM);
    EXPECT_EQ(room_.server(i).wait(seconds(1)), 0) << room_.server(i).output();
  }
}

}  // namespace
}  // namespace copresence::testing
