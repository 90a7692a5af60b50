// Cameras that fail while a viewer watches: fake Kinects (tests/support/fake_freenect), simulated cameras.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "tests/pipeline/running_room.h"
#include "tests/pipeline/watcher.h"

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

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

TEST_F(Survival, AKinectThatTakesLongToOpenAgainIsNotTakenForOneThatHangs) {
  serve_kinect();
  plug_in("A1", "transfer_error slow_open=7");  // longer than a working thread may be silent
  ASSERT_TRUE(watcher_->sees_nothing_for(milliseconds(300)));
  plug_in("A1", "slow_open=7");
  EXPECT_TRUE(watcher_->sees(10, seconds(60))) << server_says();
  EXPECT_THAT(server_says(), HasSubstr("is back"));
  EXPECT_THAT(server_says(), ::testing::Not(HasSubstr("hung")));
}

TEST_F(Survival, AKinectWhoseTransfersBlockIsReplacedWithItsProcess) {
  serve_kinect();
  plug_in("A1", "blocked stall");  // it is closed after a second without a frame, which blocks
  ASSERT_TRUE(room_.server(0).says("capture hung", seconds(60))) << server_says();
  EXPECT_THAT(server_says(), HasSubstr("from its thread \"capture\""));
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(10, seconds(60))) << server_says();
}

TEST_F(Survival, AKinectThatIsAwayAfterACrashIsWaitedForAloud) {
  serve_kinect();
  plug_in("A1", "crash");
  ASSERT_TRUE(room_.server(0).says("crashed", seconds(5)));
  unplug("A1");
  ASSERT_TRUE(room_.server(0).says("does not open", seconds(30))) << server_says();
  EXPECT_TRUE(room_.server(0).says("waiting for it", seconds(30))) << server_says();
  plug_in("A1");
  EXPECT_TRUE(watcher_->sees(30, seconds(30))) << server_says();
}

TEST_F(Survival, ACameraOfAnInstalledDriverIsListedAndStreams) {
  const std::string vendor = (program("").parent_path().parent_path() / "tests/vendor_driver").string();
  const std::string log = room_.file("vendor.log");
  const std::vector<std::string> environment{"OPENNI2_DRIVERS_PATH=" + vendor,
                                             "COPRESENCE_VENDOR_LOG=" + log};
  Process list({program("capture_server"), "--list"}, environment);
  EXPECT_EQ(list.wait(seconds(60)), 0);
  EXPECT_THAT(list.output(),
              HasSubstr("openni:2bc5/0401@1/7\n  Vendor Depth Camera, driver installed, ready"));
  EXPECT_THAT(list.output(), HasSubstr("openni:freenect://A1"));  // ours go on working beside it
  EXPECT_TRUE(std::filesystem::exists(log));
  std::filesystem::remove(log);

  room_.serve("openni:2bc5/0401@1/7", {}, environment);
  room_.serve("openni:freenect://A1", {}, environment);
  for (std::size_t i = 0; i < 2; ++i) {
    const Watcher watcher(room_.address(i));
    EXPECT_TRUE(watcher.sees(10, seconds(60))) << room_.server(i).output();
  }
  std::ifstream file(log);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "loaded\n")
      << "by the one server that needs it";
}

}  // namespace
}  // namespace copresence::testing
