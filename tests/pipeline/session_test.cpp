// render_client --record, --replay and --film with real processes: a replay shows what was recorded, always the same,
// whatever happens to the process that records.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "render_client/session/session_file.h"
#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

using session::SessionFile;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using Arguments = RunningRoom::Arguments;

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Runs a program to its end and returns its output.
std::string run(const Arguments& arguments, int expected_exit = 0) {
  Process process(arguments);
  const auto ended = process.wait(seconds(100));
  EXPECT_EQ(ended, expected_exit) << process.output();
  return process.output();
}

bool is_installed(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null").c_str()) == 0;
}

class Session : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return room_.file(name).string(); }

  /// Serves both recordings of the demo once, from a time at which clients are connected.
  void serve_once() {
    const auto begin = std::chrono::system_clock::now() + seconds(6);
    const std::string at =
        std::to_string(std::chrono::duration_cast<seconds>(begin.time_since_epoch()).count());
    for (const char* name : {"camera0.oni", "camera1.oni"})
      room_.serve(recordings() / name, {"--start-at", at, "--frames", "50"});
  }

  /// Records a few seconds of looping servers.
  void record(const std::string& name, int views) {
    for (const char* recording : {"camera0.oni", "camera1.oni"})
      room_.serve(recordings() / recording, {"--loop"});
    room_.view({"--size", "160x120", "--frames", std::to_string(views), "--record", file(name)});
  }

  std::string replay(const std::string& name, const Arguments& more, int expected_exit = 0) const {
    Arguments arguments{program("render_client"), "--replay", file(name), "--headless", "--size", "320x240"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments, expected_exit);
  }

  RunningRoom room_;
};

// The live client and the replay end with the same frames, so their last views are equal. Its pixels depend on every
// byte of these frames, and on the backgrounds that were remembered from all frames before.
TEST_F(Session, AReplayEndsWithTheViewOfTheLiveClient) {
  serve_once();
  room_.view({"--size", "320x240", "--color-matching", "off", "--record", file("a.mkv")});
  const std::string said = replay("a.mkv", {"--color-matching", "off", "--screenshot", file("replay.png")});
  EXPECT_THAT(said, HasSubstr("wrote " + file("replay.png")));
  EXPECT_EQ(bytes_of(room_.picture()), bytes_of(file("replay.png"))) << said;
}

TEST_F(Session, TheSameRecordingAndPathGiveTheSamePictures) {
  record("a.mkv", 40);
  std::ofstream(file("path.txt")) << "0 0 0 0 0 0 2\n30 0.4 -0.2 0.1 0 0 2\n";
  for (const char* film : {"one", "two"})
    replay("a.mkv", {"--view", "path:" + file("path.txt"), "--film", file(film), "--frames", "30"});
  int pictures = 0;
  std::string before;
  for (const auto& entry : std::filesystem::directory_iterator(file("one"))) {
    const std::string picture = bytes_of(entry.path());
    EXPECT_EQ(picture, bytes_of(file("two") + "/" + entry.path().filename().string())) << entry.path();
    EXPECT_NE(picture, before);
    before = picture;
    ++pictures;
  }
  EXPECT_EQ(pictures, 30);
}

TEST_F(Session, ARecordingSurvivesAKilledClient) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& client = room_.look({"--size", "160x120", "--record", file("a.mkv")});
  ASSERT_TRUE(client.says("connected", seconds(20))) << client.output();
  std::this_thread::sleep_for(seconds(4));
  const auto before = SessionFile::open(file("a.mkv"));
  ASSERT_TRUE(before) << before.error().what;
  std::this_thread::sleep_for(seconds(1));
  client.signal_group(SIGKILL);
  client.wait(seconds(5));
  const auto killed = SessionFile::open(file("a.mkv"));
  ASSERT_TRUE(killed) << killed.error().what;
  EXPECT_GT(before->end() - before->begin(), seconds(3));
  EXPECT_GT(killed->end() - before->end(), milliseconds(500));
  const std::string said = replay("a.mkv", {"--frames", "20", "--screenshot", file("view.png")});
  EXPECT_THAT(said, HasSubstr("20 of them showed every camera"));
}

TEST_F(Session, ACameraThatJoinsLaterJoinsTheReplay) {
  const std::size_t left = room_.serve(recordings() / "camera0.oni", {"--loop"});
  const std::size_t right = room_.serve(recordings() / "camera1.oni", {"--loop"});
  room_.kill_server(right);
  Process& client = room_.look({"--size", "160x120", "--record", file("a.mkv")});
  ASSERT_TRUE(client.says(room_.address(left) + ": connected", seconds(20))) << client.output();
  std::this_thread::sleep_for(seconds(4));
  room_.restart_server(right);
  ASSERT_TRUE(client.says(room_.address(right) + ": connected", seconds(20))) << client.output();
  std::this_thread::sleep_for(seconds(2));
  client.signal(SIGINT);
  ASSERT_EQ(client.wait(seconds(10)), 0) << client.output();
  const auto file_ = SessionFile::open(file("a.mkv"));
  ASSERT_TRUE(file_);
  ASSERT_EQ(file_->cameras().size(), 2u);
  replay("a.mkv", {"--stats", file("replay.json")});
  std::ifstream json(file("replay.json"));
  const auto stats = nlohmann::json::parse(json);
  EXPECT_GT(stats["view"]["frames"], 30 * 4) << "views do not wait for the camera that joins later";
  for (const auto& camera : stats["cameras"]) {
    EXPECT_GE(camera["frames_shown"], 5) << camera;
    EXPECT_EQ(camera["drops"]["decode_error"], 0) << camera;
  }
}

TEST_F(Session, OtherProgramsReadRecordingAndFilm) {
  if (!is_installed("ffprobe") || !is_installed("ffmpeg"))
    GTEST_SKIP() << "*** SKIPPED, NOT TESTED: no ffmpeg ***";
  record("a.mkv", 40);
  const std::string tracks =
      run({"/usr/bin/env", "ffprobe", "-v", "error", "-show_entries",
           "stream=codec_name,codec_type,width:stream_tags=title,filename", "-of", "compact", file("a.mkv")});
  EXPECT_THAT(tracks, HasSubstr("codec_name=h264|codec_type=video|width=640|tag:title=camera0 depth"));
  EXPECT_THAT(tracks, HasSubstr("codec_name=h264|codec_type=video|width=640|tag:title=camera0 colour"));
  EXPECT_THAT(tracks, HasSubstr("camera1 colour"));
  EXPECT_THAT(tracks, HasSubstr("tag:filename=camera1.stream"));
  // Decodes every picture of all four tracks. It prints only errors.
  EXPECT_EQ(
      run({"/usr/bin/env", "ffmpeg", "-v", "error", "-i", file("a.mkv"), "-map", "0:v", "-f", "null", "-"}),
      "");
  // A copy by another program can be replayed as well.
  run({"/usr/bin/env", "ffmpeg", "-v", "error", "-i", file("a.mkv"), "-map", "0", "-c", "copy",
       file("copy.mkv")});
  replay("copy.mkv", {"--frames", "10"});

  replay("a.mkv", {"--frames", "30", "--film", file("film.mkv")});
  EXPECT_THAT(run({"/usr/bin/env", "ffprobe", "-v", "error", "-count_frames", "-show_entries",
                   "stream=nb_read_frames,width,height", "-of", "csv=p=0", file("film.mkv")}),
              HasSubstr("320,240,30"));
}

TEST_F(Session, HostileRecordingsEndWithASentence) {
  std::ofstream(file("text.mkv")) << "0 0 0 0 0 0 2\n";
  EXPECT_THAT(replay("text.mkv", {}, 1), HasSubstr("text.mkv: is no Matroska file"));
  std::ofstream(file("empty.mkv"));
  EXPECT_THAT(replay("empty.mkv", {}, 1), HasSubstr("empty.mkv"));
  record("a.mkv", 40);
  const std::string whole = bytes_of(file("a.mkv"));
  std::ofstream(file("cut.mkv"), std::ios::binary) << whole.substr(0, whole.size() * 2 / 3);
  const std::string said = replay("cut.mkv", {});
  EXPECT_THAT(said, HasSubstr("it is replayed up to there"));
  EXPECT_THAT(said, HasSubstr("the recording is over"));
}

TEST_F(Session, AFullDiskEndsTheRecordingAndNotTheView) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  // ulimit counts in units of 1024 bytes; the file's head has 128 of them.
  Process client({"/bin/bash", "-c",
                  "ulimit -f 300; trap '' XFSZ; exec " + program("render_client").string() + " --connect " +
                      room_.address(0) + " --headless --size 160x120 --frames 30 --record " + file("a.mkv")});
  ASSERT_EQ(client.wait(seconds(60)), 0) << client.output();
  EXPECT_THAT(client.output(), HasSubstr("the recording ends here, the view goes on"));
  EXPECT_THAT(client.output(), HasSubstr("30 of them showed every camera"));
  replay("a.mkv", {"--frames", "5"});
}

}  // namespace
}  // namespace copresence::testing
