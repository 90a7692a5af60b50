// What a client shows and says while cameras are missing, stop, come back, or have sent all they had.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "render_client/display/screenshot.h"
#include "tests/pipeline/running_room.h"
#include "tests/support/virtual_display.h"
#include "tests/support/window_user.h"

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
  const auto awaited = [&] {
    const std::string title = titles();
    return title.find("waiting for " + room_.address(0) + ", ") != std::string::npos &&
           title.find(" try: connection refused") != std::string::npos;
  };
  EXPECT_TRUE(is_true_within(seconds(30), awaited)) << titles() << client.output();
  EXPECT_THAT(client.output(), HasSubstr(room_.address(0) + ": connection refused"));
  room_.restart_server(0);
  EXPECT_TRUE(is_true_within(seconds(30), [] { return titles() == "Copresence\n"; }))
      << titles() << client.output();
  client.signal(SIGTERM);
  EXPECT_EQ(client.wait(seconds(10)), 0) << client.output();
}

/// Returns the number of pixels of the colour of the window's text, in rows from `first` to `last`.
int text_pixels(const WindowUser& user, int width, int height, int first, int last) {
  const Image<Rgba8> seen = user.see(width, height);
  if (seen.empty()) return 0;
  int count = 0;
  for (int y = first; y <= last; ++y) {
    for (const Rgba8& pixel : seen.row(y)) count += pixel == Rgba8{255, 255, 255, 255};
  }
  return count;
}

TEST_F(View, TheWindowSaysWhyItIsBlackAndListsTheKeys) {
  const VirtualDisplay display;
  if (!display.is_there()) GTEST_SKIP() << "*** SKIPPED, NOT TESTED: no Xvfb ***";
  room_.serve(recordings() / "camera0.oni", {"--loop"});
  room_.kill_server(0);
  Process client(
      {program("render_client"), "--connect", room_.address(0), "--size", "640x360", "--renderer", "cpu"});
  ASSERT_TRUE(is_true_within(seconds(30), [] { return titles().find("waiting") != std::string::npos; }));
  WindowUser user("Copresence");
  ASSERT_TRUE(user.has_window());
  const auto says_why = [&] { return text_pixels(user, 640, 360, 310, 359) > 200; };
  EXPECT_TRUE(is_true_within(seconds(10), says_why)) << client.output();
  room_.restart_server(0);
  EXPECT_TRUE(is_true_within(seconds(30), [&] { return !says_why(); })) << client.output();
  const auto lists_keys = [&] { return text_pixels(user, 640, 360, 0, 150) > 500; };
  EXPECT_FALSE(lists_keys());
  user.press_key("h");
  EXPECT_TRUE(is_true_within(seconds(10), lists_keys));
  user.press_key("h");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return !lists_keys(); }));
  user.press_key("Escape");
  EXPECT_EQ(client.wait(seconds(10)), 0) << client.output();
}

TEST_F(View, AWindowThatIsRefusedSaysWhyUntilItIsClosed) {
  const VirtualDisplay display;
  if (!display.is_there()) GTEST_SKIP() << "*** SKIPPED, NOT TESTED: no Xvfb ***";
  const auto make_key = [this](const std::string& name) {
    const std::string path = room_.file(name).string();
    EXPECT_EQ(Process({program("capture_server"), "--make-key", path}).wait(seconds(10)), 0);
    return path;
  };
  room_.serve(recordings() / "camera0.oni", {"--loop", "--key", make_key("room.key")});
  Process client({program("render_client"), "--connect", room_.address(0), "--size", "640x360", "--key",
                  make_key("other.key")});
  const auto is_refused = [] { return titles().find("left out of the view") != std::string::npos; };
  ASSERT_TRUE(is_true_within(seconds(30), is_refused)) << titles() << client.output();
  WindowUser user("Copresence");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return text_pixels(user, 640, 360, 310, 359) > 200; }));
  user.press_key("Escape");
  EXPECT_EQ(client.wait(seconds(10)), 1) << client.output();
  EXPECT_THAT(client.output(), HasSubstr("render_client: " + room_.address(0)));
}

/// Returns the fraction of pixels whose colour has the hue of the first camera's layer.
double layer_share(const Image<Rgba8>& view) {
  std::size_t count = 0;
  for (const Rgba8& pixel : view.pixels())
    count += pixel.b <= 1 && pixel.r > 60 && std::abs(159 * pixel.r - 230 * pixel.g) < 2 * 230;
  return double(count) / double(std::max<std::size_t>(view.pixels().size(), 1));
}

/// Returns the mean difference of the left and the right half.
double difference_of_halves(const Image<Rgba8>& view) {
  double sum = 0;
  const int half = view.width() / 2;
  for (int y = 0; y < view.height(); ++y) {
    for (int x = 0; x < half; ++x) sum += std::abs(view(x, y).g - view(x + half, y).g);
  }
  return sum / std::max(1, half * view.height());
}

/// Writes the picture to the folder that COPRESENCE_PICTURES names, if there is one.
void keep_picture(const Image<Rgba8>& picture, const std::string& name) {
  const char* const folder = std::getenv("COPRESENCE_PICTURES");
  if (!folder) return;
  EXPECT_TRUE(display::write_png((std::filesystem::path(folder) / name).string(), picture));
}

TEST_F(View, KeysShowFiguresAndChangeTheView) {
  constexpr int kWidth = 960, kHeight = 540;
  const VirtualDisplay display;
  if (!display.is_there()) GTEST_SKIP() << "*** SKIPPED, NOT TESTED: no Xvfb ***";
  for (const char* name : {"camera0.oni", "camera1.oni"}) room_.serve(recordings() / name, {"--loop"});
  // The folder for screenshots is the one where the client was started.
  const auto folder = room_.file("").parent_path();
  const std::string command = "cd '" + folder.string() + "' && exec '" + program("render_client").string() +
                              "' --connect " + room_.address(0) + " --connect " + room_.address(1) +
                              " --size 960x540 --renderer cpu";
  Process client({"/bin/sh", "-c", command});
  ASSERT_TRUE(is_true_within(seconds(30), [] { return titles() == "Copresence\n"; })) << client.output();
  WindowUser user("Copresence");
  ASSERT_TRUE(user.has_window());
  const auto see = [&] { return user.see(kWidth, kHeight); };
  const auto shows_figures = [&] { return text_pixels(user, kWidth, kHeight, 0, 200) > 1500; };
  const auto is_complete = [&] {  // A line at the bottom says what is missing.
    return !see().empty() && text_pixels(user, kWidth, kHeight, kHeight - 40, kHeight - 1) == 0;
  };
  ASSERT_TRUE(is_true_within(seconds(20), is_complete)) << client.output();
  ASSERT_FALSE(shows_figures());
  ASSERT_LT(layer_share(see()), 0.01);

  user.press_key("F1");
  EXPECT_TRUE(is_true_within(seconds(10), shows_figures));
  std::this_thread::sleep_for(seconds(8));  // The graph and the other figures fill.
  keep_picture(see(), "overlay.png");
  user.press_key("F1");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return !shows_figures(); }));

  user.press_key("l");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return layer_share(see()) > 0.1; }));
  keep_picture(see(), "layers.png");
  user.press_key("q");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return layer_share(see()) < 0.01; }));
  keep_picture(see(), "quality.png");
  user.press_key("q");

  const double before = difference_of_halves(see());
  user.press_key("s");
  EXPECT_TRUE(is_true_within(seconds(10), [&] { return difference_of_halves(see()) < before / 2; }));

  user.press_key("p");
  const auto wrote = folder / "copresence-";
  ASSERT_TRUE(client.says("wrote copresence-", seconds(10))) << client.output();
  std::filesystem::path screenshot;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().string().starts_with(wrote.string())) screenshot = entry.path();
  }
  const cv::Mat saved = cv::imread(screenshot.string());
  EXPECT_EQ(saved.cols, kWidth);
  EXPECT_EQ(saved.rows, kHeight);
  EXPECT_GT(brightness(screenshot), 5);

  user.press_key("Escape");
  EXPECT_EQ(client.wait(seconds(10)), 0) << client.output();
}

}  // namespace
}  // namespace copresence::testing
