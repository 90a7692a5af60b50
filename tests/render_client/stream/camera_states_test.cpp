#include "render_client/stream/camera_states.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace copresence::stream {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::EndsWith;
using ::testing::HasSubstr;

const std::string kRefused = "127.0.0.1:7001: connection refused";
const std::vector<ListedCamera> kOne = {{"127.0.0.1:7001", ""}};
const std::vector<ListedCamera> kTwo = {{"127.0.0.1:7001", ""}, {"127.0.0.1:7002", ""}};
const Instant kBegin{seconds(100)};

TEST(CameraStates, SayInWordsWhyACameraSendsNoFrames) {
  CameraStates states(std::vector<ListedCamera>{{"127.0.0.1:7001", "kinect-left"}});
  EXPECT_EQ(states.why_no_frames(0), "connecting to kinect-left at 127.0.0.1:7001");
  for (int i = 0; i < 3; ++i) states.not_connected(0, kRefused, kBegin);
  EXPECT_EQ(states.why_no_frames(0),
            "waiting for kinect-left at 127.0.0.1:7001, third try: connection refused");
  states.connected(0, "kinect-left");
  EXPECT_EQ(states.why_no_frames(0),
            "kinect-left at 127.0.0.1:7001 is connected; waiting for its first picture");
  states.status(0, "the camera is unplugged");
  EXPECT_EQ(states.why_no_frames(0), "kinect-left at 127.0.0.1:7001: the camera is unplugged");
  states.status(0, "");
  states.availability(0, Availability::kShown, "");
  EXPECT_EQ(states.why_no_frames(0), "");
  states.availability(0, Availability::kLeftOut, "127.0.0.1:7001: the server hung up");
  EXPECT_EQ(states.why_no_frames(0),
            "kinect-left at 127.0.0.1:7001 is left out of the view: the server hung up");
  states.availability(0, Availability::kAwaited, "");
  states.over(0, "the recording is over");
  EXPECT_EQ(states.why_no_frames(0), "kinect-left at 127.0.0.1:7001: the recording is over");
}

TEST(CameraStates, UseTheAddressAloneAsLongAsTheNameIsUnknown) {
  CameraStates states(kOne);
  states.not_connected(0, kRefused, kBegin);
  EXPECT_EQ(states.why_no_frames(0), "waiting for 127.0.0.1:7001, first try: connection refused");
  states.connected(0, "left");
  states.not_connected(0, kRefused, kBegin);
  EXPECT_EQ(states.why_no_frames(0), "waiting for left at 127.0.0.1:7001, first try: connection refused");
}

TEST(CameraStates, TheTitleSaysWhatIsAwaited) {
  CameraStates states(kOne);
  EXPECT_EQ(states.title("Copresence"), "Copresence: connecting to 127.0.0.1:7001");
  states.connected(0, "left");
  states.availability(0, Availability::kShown, "");
  EXPECT_EQ(states.title("Copresence"), "Copresence");
}

TEST(CameraStates, TheTitleNamesTheFirstAndCountsTheOthers) {
  CameraStates states(
      std::vector<ListedCamera>{{"127.0.0.1:7001", ""}, {"127.0.0.1:7002", ""}, {"127.0.0.1:7003", ""}});
  states.connected(1, "middle");
  states.availability(1, Availability::kShown, "");
  states.not_connected(0, kRefused, kBegin);
  states.not_connected(2, "127.0.0.1:7003: connection refused", kBegin);
  EXPECT_THAT(states.title("Copresence"), HasSubstr("7001"));
  EXPECT_THAT(states.title("Copresence"), EndsWith("(and 1 camera more)"));
}

TEST(CameraStates, TheLogIsToldAtOnceThenSeldom) {
  CameraStates states(kOne);
  std::vector<std::string> said;
  for (Instant now = kBegin; now < kBegin + seconds(135); now += milliseconds(500)) {
    if (const auto line = states.not_connected(0, kRefused, now)) said.push_back(*line);
  }
  ASSERT_EQ(said.size(), 4U) << "at 0, 10, 70 and 130 s";
  EXPECT_EQ(said[0], kRefused + "; waiting for it");
  EXPECT_EQ(said[1], kRefused + "; still waiting for it, 21st try");
  states.connected(0, "left");
  EXPECT_TRUE(states.not_connected(0, kRefused, kBegin + seconds(140))) << "lost again";
}

TEST(CameraStates, AllAreOverWhenEachServerHasEndedForGood) {
  CameraStates states(kTwo);
  states.connected(0, "left");
  states.connected(1, "right");
  states.over(0, "the recording is over");
  EXPECT_FALSE(states.all_over());
  EXPECT_FALSE(states.not_connected(0, kRefused, kBegin)) << "nobody expects it to listen";
  EXPECT_THAT(states.title("Copresence"), HasSubstr("left at 127.0.0.1:7001: the recording is over"));
  states.over(1, "the recording is over");
  EXPECT_TRUE(states.all_over());
  states.connected(0, "left");
  EXPECT_FALSE(states.all_over()) << "it was started again";
}

TEST(CameraStates, OrdinalsAreEnglish) {
  for (const auto& [number, text] : {std::pair{1, "first"},
                                     {3, "third"},
                                     {10, "tenth"},
                                     {11, "11th"},
                                     {12, "12th"},
                                     {13, "13th"},
                                     {20, "20th"},
                                     {21, "21st"},
                                     {102, "102nd"},
                                     {111, "111th"}})
    EXPECT_EQ(ordinal(number), text);
}

TEST(CameraStates, ACameraThatIsLeftOutIsNamedAndHoldsNobodyUp) {
  CameraStates states(kTwo);
  states.connected(0, "left");
  states.connected(1, "right");
  states.availability(0, Availability::kShown, "");
  EXPECT_EQ(states.left_out(1), "");
  states.availability(1, Availability::kLeftOut, "127.0.0.1:7002: the server hung up");
  EXPECT_EQ(states.left_out(1), "127.0.0.1:7002: the server hung up");
  EXPECT_EQ(states.left_out(0), "");
  EXPECT_EQ(states.name(1), "right");
  EXPECT_THAT(states.title("Copresence"),
              HasSubstr("right at 127.0.0.1:7002 is left out of the view: the server hung up"));
  states.connected(1, "right");
  EXPECT_NE(states.left_out(1), "") << "a welcome alone shows nothing";
  EXPECT_FALSE(states.all_over()) << "the other one goes on";
  states.over(0, "the recording is over");
  EXPECT_TRUE(states.all_over());
  states.availability(1, Availability::kShown, "");
  EXPECT_EQ(states.left_out(1), "");
  EXPECT_FALSE(states.all_over());
}

TEST(CameraStates, SaysOnceThatEveryCameraIsRefused) {
  int told = 0;
  CameraStates states(kTwo, [&] { ++told; });
  states.availability(0, Availability::kRefused, "a:1: install the same release");
  states.availability(1, Availability::kLeftOut, "b:2: the server hung up");
  EXPECT_EQ(told, 0) << "the second may come back";
  states.availability(1, Availability::kRefused, "b:2: codec \"h265\" is unknown");
  states.availability(1, Availability::kRefused, "b:2: codec \"h266\" is unknown");
  EXPECT_EQ(told, 1);
  ASSERT_TRUE(states.all_refused());
  EXPECT_EQ(
      states.all_refused()->what,
      "none of the cameras can be shown: a:1: install the same release; b:2: codec \"h265\" is unknown");
}

TEST(CameraStates, OfOneCameraSaysNothingButWhyItIsRefused) {
  CameraStates states(kOne);
  states.availability(0, Availability::kRefused, "a:1: install the same release");
  ASSERT_TRUE(states.all_refused());
  EXPECT_EQ(states.all_refused()->what, "a:1: install the same release");
}

}  // namespace
}  // namespace copresence::stream
