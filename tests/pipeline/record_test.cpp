// capture_server --record with real processes: what comes out is what went in, whatever happens to the process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <thread>

#include "capture_server/recording/oni_reader.h"
#include "tests/pipeline/running_room.h"
#include "tests/support/real_recordings.h"

namespace copresence::testing {
namespace {

using recording::OniReader;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using Kind = recording::RecordedStream::Kind;

std::string listen_somewhere() {
  return "127.0.0.1:" + std::to_string(free_port());
}

std::string copy_at_full_speed(const std::string& from, const std::string& to) {
  Process server({program("capture_server"), "--source", from, "--record", to, "--pace", "fast", "--listen",
                  listen_somewhere()});
  EXPECT_EQ(server.wait(seconds(60)), 0) << server.output();
  return server.output();
}

void expect_same_depth(const std::string& a, const std::string& b) {
  const auto first = OniReader::open(a), second = OniReader::open(b);
  ASSERT_TRUE(first && second);
  const auto& times = first->summary().find(Kind::kDepth)->timestamps_us;
  ASSERT_EQ(times, second->summary().find(Kind::kDepth)->timestamps_us);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto one = first->depth(i), other = second->depth(i);
    ASSERT_TRUE(one && other);
    ASSERT_EQ(*one, *other) << "frame " << i + 1;
  }
}

TEST(Record, ACopyIsTheSameInDepthBitByBit) {
  TemporaryFolder folder;
  const std::string source = recordings() / "camera0.oni";
  copy_at_full_speed(source, folder / "copy.oni");
  expect_same_depth(source, folder / "copy.oni");
  copy_at_full_speed(folder / "copy.oni", folder / "again.oni");
  expect_same_depth(source, folder / "again.oni");
  const auto note = OniReader::open(folder / "copy.oni")->summary().camera_metadata;
  ASSERT_TRUE(note);
  EXPECT_EQ(note->world_from_camera, OniReader::open(source)->summary().camera_metadata->world_from_camera);
}

TEST(Record, ACopyOfARealKinectsRecordingIsTheSame) {
  const auto source = test::real_recording("arm_small.oni");
  if (!source) GTEST_SKIP() << "SKIPPED: no real recordings on this machine (COPRESENCE_RECORDINGS)";
  TemporaryFolder folder;
  copy_at_full_speed(*source, folder / "copy.oni");
  expect_same_depth(*source, folder / "copy.oni");
}

TEST(Record, AKilledServersFilePlaysUpToTheLastSecond) {
  TemporaryFolder folder;
  Process server({program("capture_server"), "--source", recordings() / "camera0.oni", "--loop", "--record",
                  folder / "killed.oni", "--listen", listen_somewhere()});
  ASSERT_TRUE(server.says("recording to", seconds(10)));
  std::this_thread::sleep_for(milliseconds(2500));
  server.signal_group(SIGKILL);
  server.wait(seconds(5));
  const auto reader = OniReader::open(folder / "killed.oni");
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_GT(reader->summary().find(Kind::kDepth)->frames(), 40u);
  Process replay({program("capture_server"), "--source", folder / "killed.oni", "--pace", "fast", "--listen",
                  listen_somewhere()});
  EXPECT_EQ(replay.wait(seconds(20)), 0) << replay.output();
}

TEST(Record, AStopFinishesTheFileWithinASecond) {
  TemporaryFolder folder;
  Process server({program("capture_server"), "--source", recordings() / "camera0.oni", "--loop", "--record",
                  folder / "a.oni", "--listen", listen_somewhere()});
  ASSERT_TRUE(server.says("recording to", seconds(10)));
  std::this_thread::sleep_for(milliseconds(500));
  server.signal(SIGTERM);
  EXPECT_EQ(server.wait(milliseconds(1500)), 0) << server.output();
  EXPECT_THAT(server.output(), HasSubstr("0 left out"));
  EXPECT_TRUE(OniReader::open(folder / "a.oni"));
}

TEST(Record, StreamingGoesOnWhenTheFileCannotGrow) {
  RunningRoom room;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1'000'000;
  setrlimit(RLIMIT_FSIZE, &small);
  room.serve(recordings() / "camera0.oni", {"--loop", "--record", room.file("a.oni")});
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_TRUE(room.server(0).says("streaming goes on", seconds(20))) << room.server(0).output();
  const auto stats = room.view({"--frames", "30", "--size", "320x180"});
  EXPECT_GT(stats["cameras"][0]["frames_received"], 20);
  const auto reader = OniReader::open(room.file("a.oni"));
  ASSERT_TRUE(reader) << reader.error().what;
  EXPECT_GT(reader->summary().find(Kind::kDepth)->frames(), 0u);
}

TEST(Record, AFileThatCannotBeMadeIsSaidAtOnce) {
  Process server({program("capture_server"), "--source", recordings() / "camera0.oni", "--record",
                  "/nonexistent/a.oni", "--listen", listen_somewhere()});
  EXPECT_EQ(server.wait(seconds(5)), 1);
  EXPECT_THAT(server.output(), HasSubstr("/nonexistent/a.oni"));
}

}  // namespace
}  // namespace copresence::testing
