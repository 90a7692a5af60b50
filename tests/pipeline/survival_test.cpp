// Cameras that fail while a viewer watches: fake Kinects (tests/support/fake_freenect), simulated cameras.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>

#include "common/wire/frame_client.h"
#include "tests/pipeline/running_room.h"

namespace copresence::testing {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

// A viewer without a picture: it stays connected as render_client does and notes what comes.
class Watcher {
 public:
  explicit Watcher(std::string address)
      : address_(std::move(address)), thread_([this](std::stop_token stop) { watch(stop); }) {}

  std::uint64_t frames() const { return frames_; }
  std::string notices() const {
    const std::lock_guard lock(mutex_);
    return notices_;
  }

  // Whether `count` more frames come within `timeout`.
  bool sees(std::uint64_t count, milliseconds timeout) const {
    const std::uint64_t wanted = frames_ + count;
    for (const auto end = steady_clock::now() + timeout; frames_ < wanted;) {
      if (steady_clock::now() > end) return false;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return true;
  }

  // Whether no frame comes for `time` within the next ten seconds.
  bool sees_nothing_for(milliseconds time) const {
    const auto give_up = steady_clock::now() + seconds(10);
    auto since = steady_clock::now();
    for (std::uint64_t last = frames_; steady_clock::now() < give_up;) {
      if (frames_ != last) {
        last = frames_;
        since = steady_clock::now();
      }
      if (steady_clock::now() - since > time) return true;
      std::this_thread::sleep_for(milliseconds(2));
    }
    return false;
  }

  // The longest pause between two frames so far.
  milliseconds longest_pause() const { return milliseconds(longest_pause_ms_); }
  void forget_pauses() { longest_pause_ms_ = 0; }

 private:
  void watch(std::stop_token stop) {
    auto last = steady_clock::now();
    while (!stop.stop_requested()) {
      auto client = wire::FrameClient::connect(address_, milliseconds(2000), stop);
      if (!client) {
        std::this_thread::sleep_for(milliseconds(100));
        continue;
      }
      client->on_notice([this](const std::string& notice) {
        const std::lock_guard lock(mutex_);
        notices_ += "[" + notice + "]";
      });
      while (client->receive(stop)) {
        const auto now = steady_clock::now();
        if (frames_ > 0)
          longest_pause_ms_ =
              std::max<std::int64_t>(longest_pause_ms_, duration_cast<milliseconds>(now - last).count());
        last = now;
        ++frames_;
      }
    }
  }

  const std::string address_;
  std::atomic<std::uint64_t> frames_ = 0;
  std::atomic<std::int64_t> longest_pause_ms_ = 0;
  mutable std::mutex mutex_;
  std::string notices_;
  std::jthread thread_;
};

class Survival : public ::testing::Test {
 protected:
  Survival() {
    ::setenv("COPRESENCE_FAKE_KINECTS", (bus_ / "").c_str(), 1);
    ::setenv("LD_LIBRARY_PATH", (program("").parent_path().parent_path() / "tests" / "fake_freenect").c_str(),
             1);
    plug_in("A1");
  }
  void plug_in(const std::string& serial, const std::string& faults = "") const {
    std::ofstream(bus_ / serial) << faults;
  }
  void unplug(const std::string& serial) const { std::filesystem::remove(bus_ / serial); }

  void serve_kinect() {
    room_.serve("openni:freenect://A1", {"--name", "kinect"});
    watcher_ = std::make_unique<Watcher>(room_.address(0));
    ASSERT_TRUE(watcher_->sees(10, seconds(10))) << room_.server(0).output();
    watcher_->forget_pauses();
  }
  std::string server_says() { return room_.server(0).output(); }

  TemporaryFolder bus_;
  RunningRoom room_;
  std::unique_ptr<Watcher> watcher_;
};

TEST_F(Survival, AnUnpluggedKinectIsSaidAndGoesOnWithinASecondOfReplugging) {
  serve_kinect();
  for (int round = 1; round <= 3; ++round) {
    unplug("A1");
    ASSERT_TRUE(watcher_->sees_nothing_for(milliseconds(300)));
    EXPECT_THAT(watcher_->notices(), HasSubstr("unplugged"));
    plug_in("A1");
    ASSERT_TRUE(watcher_->sees(1, milliseconds(1000))) << server_says();
    ASSERT_TRUE(watcher_->sees(10, seconds(2)));
    EXPECT_THAT(watcher_->notices(), ::testing::EndsWith("[]"));
  }
  EXPECT_THAT(server_says(), HasSubstr("is back"));
}

TEST_F(Survival, AStalledKinectIsOpenedAgain) {
  serve_kinect();
  plug_in("A1", "stall");
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_THAT(watcher_->notices(), HasSubstr("sends no frames"));
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(30, seconds(5))) << server_says();
}

TEST_F(Survival, AFailedTransferCostsAMoment) {
  serve_kinect();
  plug_in("A1", "transfer_error");
  std::this_thread::sleep_for(milliseconds(100));
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(30, seconds(3))) << server_says();
  EXPECT_LT(watcher_->longest_pause(), seconds(1));
}

TEST_F(Survival, ACrashInTheDriverCostsItsViewersAtMostTwoSeconds) {
  serve_kinect();
  plug_in("A1", "crash");
  ASSERT_TRUE(room_.server(0).says("crashed", seconds(5)));
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(30, seconds(5))) << server_says();
  EXPECT_LT(watcher_->longest_pause(), seconds(2));
  RecordProperty("pause_ms", static_cast<int>(watcher_->longest_pause().count()));
}

TEST_F(Survival, AKinectThatIsAwayAfterACrashIsWaitedFor) {
  serve_kinect();
  plug_in("A1", "crash");
  ASSERT_TRUE(room_.server(0).says("crashed", seconds(5)));
  unplug("A1");
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_EQ(room_.server(0).wait(milliseconds(1)), std::nullopt) << server_says();
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(30, seconds(4))) << server_says();
}

TEST_F(Survival, ADriverThatHangsIsReplaced) {
  const auto control = bus_ / "control";
  std::ofstream(control).close();
  room_.serve("simulated:empty-room?camera=0&control=" + control.string());
  watcher_ = std::make_unique<Watcher>(room_.address(0));
  ASSERT_TRUE(watcher_->sees(10, seconds(10))) << server_says();
  std::ofstream(control) << "hang";
  ASSERT_TRUE(room_.server(0).says("hung", seconds(10))) << server_says();
  std::ofstream(control).close();
  EXPECT_TRUE(watcher_->sees(10, seconds(6))) << server_says();
}

TEST_F(Survival, FourServersOfTwoKinectsAndTwoSimulatedCamerasMindEachOtherNot) {
  plug_in("B2");
  room_.serve("openni:freenect://B2");
  room_.serve("openni:freenect://A1");
  room_.serve("simulated:room?camera=0");
  room_.serve("simulated:room?camera=1");
  std::vector<std::unique_ptr<Watcher>> watchers;
  for (std::size_t i = 0; i < 4; ++i) watchers.push_back(std::make_unique<Watcher>(room_.address(i)));
  for (const auto& watcher : watchers) ASSERT_TRUE(watcher->sees(10, seconds(20)));
  unplug("B2");
  ASSERT_TRUE(watchers[0]->sees_nothing_for(milliseconds(300)));
  for (std::size_t i = 1; i < 4; ++i) EXPECT_TRUE(watchers[i]->sees(10, seconds(3))) << i;
}

TEST_F(Survival, AControlThatTheCameraLacksIsRefusedWithTheWayOut) {
  room_.serve("simulated:empty-room?camera=0", {"--exposure", "fixed"});
  EXPECT_EQ(room_.server(0).wait(seconds(10)), 1);
  EXPECT_THAT(server_says(), HasSubstr("--exposure"));
}

TEST_F(Survival, WhatACameraLeavesOutForTheOthersTurnsStandsInTheStatistics) {
  room_.serve("simulated:empty-room?camera=0&cameras=2&projectors=" + room_.file("projectors").string(),
              {"--projector-slot", "1/2:300"});
  const auto stats = room_.view({"--frames", "40", "--size", "320x180"});
  const auto& pictures = stats["cameras"][0]["pictures"];
  EXPECT_GT(pictures["dark"], 10) << pictures;
  EXPECT_EQ(stats["cameras"][0]["drops"]["unaccounted"], 0);
}

TEST_F(Survival, AKinectTakesFixedExposure) {
  room_.serve("openni:freenect://A1", {"--exposure", "fixed", "--white-balance", "fixed", "--frames", "65"});
  EXPECT_EQ(room_.server(0).wait(seconds(10)), 0) << server_says();
}

TEST_F(Survival, TheListNamesEveryKinectAndItsModes) {
  plug_in("B2", "busy");
  Process list({program("capture_server"), "--list"});
  EXPECT_EQ(list.wait(seconds(10)), 0);
  EXPECT_THAT(list.output(),
              HasSubstr("openni:freenect://A1\n  Microsoft Kinect, serial A1, driver kinect_v1, ready"));
  EXPECT_THAT(list.output(), HasSubstr("infrared 640x480 at 30"));
  EXPECT_THAT(list.output(), HasSubstr("openni:freenect://B2"));
  EXPECT_THAT(list.output(), HasSubstr("not ready"));
  EXPECT_THAT(list.output(), HasSubstr("does not open (Could not claim"));
  EXPECT_THAT(list.output(), HasSubstr("plug it in again"));
  EXPECT_THAT(list.output(), HasSubstr("simulated:room?camera=0"));
}

}  // namespace
}  // namespace copresence::testing
