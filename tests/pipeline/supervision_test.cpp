// Servers whose process is killed, suspended, stopped at a bad moment, or stands still: what they say and how they go on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <thread>

#include "capture_server/recording/oni_reader.h"
#include "tests/pipeline/running_room.h"
#include "tests/pipeline/watcher.h"

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::AnyOf;
using ::testing::Eq;
using ::testing::HasSubstr;
using ::testing::Not;

class Supervision : public ::testing::Test {
 protected:
  // A server that plays for ever, and somebody who watches it.
  void play(const RunningRoom::Arguments& more = {}, const RunningRoom::Arguments& environment = {}) {
    RunningRoom::Arguments arguments{"--loop"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    room_.serve(recordings() / "camera0.oni", arguments, environment);
    watch();
  }
  void serve_simulated(const std::string& control, const RunningRoom::Arguments& more = {}) {
    set(control, "");
    room_.serve("simulated:empty-room?camera=0&control=" + file(control), more);
    watch();
  }
  void watch() {
    watcher_ = std::make_unique<Watcher>(room_.address(0));
    ASSERT_TRUE(watcher_->sees(10, seconds(60))) << says();
  }

  void set(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  void remove(const std::string& name) const { std::filesystem::remove_all(folder_ / name); }
  std::string file(const std::string& name) const { return folder_ / name; }

  // The environment in which the calls that are named by files of this folder stand still.
  RunningRoom::Arguments with_stalls() const {
    return {"LD_PRELOAD=" + (program("").parent_path().parent_path() / "tests/libstalled_calls.so").string(),
            "COPRESENCE_STALLS=" + file("")};
  }

  Process& server() { return room_.server(0); }
  std::string says() { return server().output(); }

  TemporaryFolder folder_;
  RunningRoom room_;
  std::unique_ptr<Watcher> watcher_;
};

// --- the true reason

TEST_F(Supervision, ARecordingGoesOnWhenItsProcessIsKilled) {
  play();
  for (const int signal : {SIGKILL, SIGTERM, SIGSEGV}) {
    const pid_t child = server().child();
    ASSERT_EQ(::kill(child, signal), 0);
    ASSERT_TRUE(server().says(std::string("(") + ::strsignal(signal), seconds(30))) << says();
    ASSERT_TRUE(watcher_->sees(30, seconds(60))) << says();
    EXPECT_NE(server().child(), child);
  }
  EXPECT_THAT(says(), HasSubstr("capture was killed by"));
  EXPECT_THAT(says(), Not(HasSubstr("damaged")));
}

TEST_F(Supervision, ARecordingGoesOnWhenItsProcessWasSuspended) {
  play();
  const pid_t child = server().child();
  ASSERT_EQ(::kill(child, SIGSTOP), 0);
  ASSERT_TRUE(server().says("suspended by another process's signal", seconds(60))) << says();
  EXPECT_TRUE(watcher_->sees(30, seconds(60))) << says();
  EXPECT_EQ(server().child(), child);
  EXPECT_THAT(says(), Not(HasSubstr("damaged")));
}

TEST_F(Supervision, ASettingsFileThatIsWrongAtSighupIsSaidAndChangesNothing) {
  set("server.toml", "depth-qp = 24\n");
  play({"--config", file("server.toml")});
  const pid_t child = server().child();
  set("server.toml", "depth-qp = \"many\"\n");
  server().signal(SIGHUP);
  ASSERT_TRUE(server().says("everything goes on as before", seconds(30))) << says();
  EXPECT_TRUE(watcher_->sees(30, seconds(60)));
  EXPECT_EQ(server().child(), child);
}

// --- stopping

TEST_F(Supervision, AStopIsNotLostWhenTheProcessCrashesOnItsWay) {
  for (const int crash : {SIGSEGV, SIGABRT, SIGKILL}) {
    RunningRoom room;
    room.serve(recordings() / "camera0.oni", {"--loop"});
    ASSERT_TRUE(room.server(0).says("depth adaptive", seconds(60)));
    const pid_t child = room.server(0).child();
    room.server(0).signal(SIGTERM);
    ::kill(child, crash);
    EXPECT_THAT(room.server(0).wait(seconds(30)), Eq(0)) << room.server(0).output();
    // Where the crash was first, the parent had nothing to stop yet.
    EXPECT_THAT(room.server(0).output(), Not(HasSubstr("damaged")));
  }
}

TEST_F(Supervision, CtrlCEndsItAtEveryMomentOfItsBeginning) {
  for (int after_ms = 0; after_ms <= 120; after_ms += 15) {
    RunningRoom room;
    room.serve("simulated:empty-room?camera=0");
    std::this_thread::sleep_for(milliseconds(after_ms));
    room.server(0).signal_group(SIGINT);  // as a terminal does
    // By the signal itself where it came before anything was begun.
    EXPECT_THAT(room.server(0).wait(seconds(30)), AnyOf(Eq(0), Eq(128 + SIGINT))) << after_ms;
    EXPECT_THAT(room.server(0).output(), Not(HasSubstr("again"))) << after_ms;
  }
}

TEST_F(Supervision, OneCtrlCLetsItFinishItsRecording) {
  play({"--record", file("a.oni")});
  server().signal_group(SIGINT);
  EXPECT_EQ(server().wait(seconds(30)), 0) << says();
  EXPECT_THAT(says(), HasSubstr("frames, "));
  EXPECT_TRUE(recording::OniReader::open(file("a.oni")));
}

TEST_F(Supervision, ASecondCtrlCEndsItAtOnceWhileItsDriverHangs) {
  serve_simulated("control");
  set("control", "hang");
  ASSERT_TRUE(watcher_->sees_nothing_for(milliseconds(300)));
  server().signal(SIGINT);
  std::this_thread::sleep_for(milliseconds(250));
  server().signal(SIGINT);
  // Killed by the second one, or by the limit of the first where this machine is that slow.
  EXPECT_THAT(server().wait(seconds(30)), AnyOf(Eq(128 + SIGINT), Eq(1))) << says();
}

TEST_F(Supervision, TwoStopsOfOneMomentAreOne) {
  play({"--record", file("a.oni")});
  server().signal_group(SIGTERM);  // as timeout(1) does: to the program, and to its group
  server().signal(SIGTERM);
  EXPECT_EQ(server().wait(seconds(30)), 0) << says();
  EXPECT_THAT(says(), HasSubstr("frames, "));
}

// --- threads that stand still

TEST_F(Supervision, AHungEncoderIsReplaced) {
  play({}, with_stalls());
  set("encoder", "");
  ASSERT_TRUE(server().says("no sign of life from its thread \"encode\"", seconds(60))) << says();
  remove("encoder");
  EXPECT_TRUE(watcher_->sees(30, seconds(60))) << says();
  EXPECT_THAT(says(), Not(HasSubstr("damaged")));
}

TEST_F(Supervision, AHungWireThreadIsReplaced) {
  play({}, with_stalls());
  set("wire", "");
  ASSERT_TRUE(server().says("no sign of life from its thread \"wire\"", seconds(60))) << says();
  remove("wire");
  EXPECT_TRUE(watcher_->sees(30, seconds(60))) << says();
}

// --- recording

TEST_F(Supervision, AStalledDiskIsNotADamagedRecording) {
  constexpr std::size_t kFrames = 200;
  Process server({program("capture_server"), "--source", recordings() / "camera0.oni", "--loop", "--pace",
                  "fast", "--frames", std::to_string(kFrames), "--record", file("copy.oni"), "--listen",
                  "127.0.0.1:" + std::to_string(free_port())},
                 with_stalls());
  ASSERT_TRUE(server.says("recording to", seconds(60))) << server.output();
  set("disk", "");
  const auto end = steady_clock::now() + seconds(12);  // twice what a hang may last
  ASSERT_TRUE(server.says("waiting for the disk", seconds(60))) << server.output();
  std::this_thread::sleep_until(end);
  remove("disk");
  EXPECT_EQ(server.wait(seconds(100)), 0) << server.output();
  EXPECT_THAT(server.output(), Not(HasSubstr("damaged")));
  EXPECT_THAT(server.output(), Not(HasSubstr("hung")));
  const auto copy = recording::OniReader::open(file("copy.oni"));
  ASSERT_TRUE(copy) << copy.error().what;
  EXPECT_EQ(copy->summary().find(recording::RecordedStream::Kind::kDepth)->frames(), kFrames);
}

TEST_F(Supervision, AStopWhileTheDiskStandsStillSaysSo) {
  play({"--record", file("a.oni")}, with_stalls());
  set("disk", "");
  ASSERT_TRUE(server().says("too slow to record", seconds(60))) << says();
  server().signal(SIGTERM);
  EXPECT_EQ(server().wait(seconds(30)), 1);
  EXPECT_THAT(says(), HasSubstr("while writing the last frames of " + file("a.oni")));
}

TEST_F(Supervision, AFolderThatIsGoneAfterACrashEndsTheServerWithThatSentence) {
  std::filesystem::create_directory(folder_ / "takes");
  serve_simulated("control", {"--record", file("takes/a.oni")});
  remove("takes");
  set("control", "crash");
  ASSERT_TRUE(server().says("capture crashed", seconds(60))) << says();
  set("control", "");
  EXPECT_EQ(server().wait(seconds(60)), 1) << says();
  EXPECT_THAT(says(), HasSubstr(file("takes/a.oni") + ": cannot be written: No such file or directory"));
  EXPECT_THAT(says(), Not(HasSubstr("Segmentation")));
}

TEST_F(Supervision, ServersThatBeginAtOnceRecordIntoFilesOfTheirOwn) {
  for (std::size_t i = 0; i < 3; ++i)
    room_.serve(recordings() / "camera0.oni", {"--pace", "fast", "--record", file("a.oni")});
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(room_.server(i).wait(seconds(60)), 0) << room_.server(i).output();
  for (const char* name : {"a.oni", "a-2.oni", "a-3.oni"}) {
    const auto reader = recording::OniReader::open(file(name));
    ASSERT_TRUE(reader) << name << ": " << reader.error().what;
    EXPECT_EQ(reader->summary().find(recording::RecordedStream::Kind::kDepth)->frames(), 60u) << name;
  }
}

}  // namespace
}  // namespace copresence::testing
