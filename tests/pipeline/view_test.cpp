// What a client shows and says while cameras are missing, stop, come back, or have sent all they had.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "tests/pipeline/running_room.h"
#include "tests/support/virtual_display.h"

// last: X defines words that others use as names
#include <X11/Xlib.h>

namespace copresence::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;

/// Mean of all channels of a picture, 0 to 255.
double brightness(const std::filesystem::path& picture) {
  const cv::Mat image = cv::imread(picture.string());
  EXPECT_FALSE(image.empty()) << picture;
  const cv::Scalar means = cv::mean(image);
  return (means[0] + means[1] + means[2]) / 3;
}

bool is_true_within(milliseconds limit, const std::function<bool()>& holds) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < end) {
    if (holds()) return true;
    std::this_thread::sleep_for(milliseconds(50));
  }
  return holds();
}

class View : public ::testing::Test {
 protected:
  /// Ends a running client as Ctrl-C does.
  static void stop(Process& client) {
    client.signal(SIGINT);
    EXPECT_EQ(client.wait(seconds(10)), 0) << client.output();
  }

  RunningRoom room_;
};

TEST_F(View, ACameraWhoseServerDiesIsGoneFromTheViewAfterAWhile) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& client = room_.look({"--size", "160x120", "--stale", "3"});
  ASSERT_TRUE(client.says("connected", seconds(20))) << client.output();
  std::this_thread::sleep_for(seconds(1));
  room_.kill_server(0);
  ASSERT_TRUE(client.says("sends no pictures", seconds(20))) << client.output();
  std::this_thread::sleep_for(seconds(4));  // 1 s has passed since the last frame; 3 s suffice
  stop(client);
  EXPECT_EQ(brightness(room_.picture()), 0);
  EXPECT_EQ(room_.stats()["cameras"][0]["times_stale"], 1);
}

TEST_F(View, ACameraThatComesBackIsShownAtOnce) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& client = room_.look({"--size", "160x120", "--stale", "0.5"});
  ASSERT_TRUE(client.says("connected", seconds(20))) << client.output();
  std::this_thread::sleep_for(milliseconds(500));
  room_.kill_server(0);
  ASSERT_TRUE(client.says("sends no pictures", seconds(20))) << client.output();
  room_.restart_server(0);
  ASSERT_TRUE(client.says("is back in the view", seconds(20))) << client.output();
  stop(client);
}

TEST_F(View, AHeadlessClientEndsWithTheRecordingsAndSaysSo) {
  // Late enough for a client to be there.
  const auto begin = std::chrono::system_clock::now() + seconds(10);
  const std::string at =
      std::to_string(std::chrono::duration_cast<seconds>(begin.time_since_epoch()).count());
  for (const char* name : {"camera0.oni", "camera1.oni"})
    room_.serve(recordings() / name, {"--start-at", at, "--frames", "55"});
  Process& client = room_.look({"--size", "160x120", "--frames", "100000"});
  EXPECT_EQ(client.wait(seconds(60)), 0) << client.output();
  const std::string said = client.output();
  EXPECT_THAT(said, HasSubstr("all frames that --frames asked for are sent"));
  EXPECT_THAT(said, HasSubstr("every camera has ended before 100000 views were drawn"));
  EXPECT_THAT(said, HasSubstr("160x120"));
  EXPECT_THAT(said, HasSubstr("wrote " + room_.picture().string()));
  EXPECT_GT(brightness(room_.picture()), 5) << "the last view, not one that has faded";
}

TEST_F(View, ARecordingThatIsOverIsCalledThat) {
  const auto begin = std::chrono::system_clock::now() + seconds(8);
  const std::string at =
      std::to_string(std::chrono::duration_cast<seconds>(begin.time_since_epoch()).count());
  room_.serve(recordings() / "camera0.oni", {"--start-at", at});
  Process& client = room_.look({"--size", "160x120"});
  EXPECT_EQ(client.wait(seconds(60)), 0) << client.output();
  EXPECT_THAT(client.output(), HasSubstr(room_.address(0) + ": the recording is over"));
  EXPECT_EQ(room_.server(0).wait(seconds(10)), 0) << room_.server(0).output();
}

TEST_F(View, AServerThatIsStoppedIsWaitedFor) {
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  Process& client = room_.look({"--size", "160x120"});
  ASSERT_TRUE(client.says("connected", seconds(20))) << client.output();
  room_.server(0).signal(SIGTERM);
  ASSERT_TRUE(client.says("connection refused", seconds(20))) << client.output();
  EXPECT_EQ(client.wait(milliseconds(300)), std::nullopt) << client.output();
  stop(client);
}

/// The titles of all windows on the display.
std::string titles() {
  Display* const display = XOpenDisplay(nullptr);
  if (!display) return {};
  ::Window root = 0, parent = 0, *children = nullptr;
  unsigned count = 0;
  std::string all;
  if (XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count)) {
    for (unsigned i = 0; i < count; ++i) {
      char* name = nullptr;
      if (XFetchName(display, children[i], &name) && name) all += std::string(name) + "\n";
      if (name) XFree(name);
    }
    if (children) XFree(children);
  }
  XCloseDisplay(display);
  return all;
}

TEST_F(View, TheWindowsTitleSaysWhatIsAwaited) {
  const VirtualDisplay display;
  if (!display.is_there()) GTEST_SKIP() << "*** SKIPPED, NOT TESTED: no Xvfb ***";
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  room_.kill_server(0);
  Process client(
      {program("render_client"), "--connect", room_.address(0), "--size", "320x240", "--renderer", "cpu"});
  const auto awaited = "try: waiting for " + room_.address(0) + ": connection refused";
  EXPECT_TRUE(is_true_within(seconds(30), [&] { return titles().find(awaited) != std::string::npos; }))
      << titles() << client.output();
  EXPECT_THAT(client.output(), HasSubstr(room_.address(0) + ": connection refused"));
  room_.restart_server(0);
  EXPECT_TRUE(is_true_within(seconds(30), [] { return titles() == "Copresence\n"; }))
      << titles() << client.output();
  client.signal(SIGTERM);
  EXPECT_EQ(client.wait(seconds(10)), 0) << client.output();
}

}  // namespace
}  // namespace copresence::testing
