#include "capture_server/recorder/recording_thread.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

#include "capture_server/recording/oni_check.h"
#include "tests/support/recording_scene.h"

namespace copresence::server {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = recording::RecordedStream::Kind;

class RecordingThreadTest : public testing::Test {
 protected:
  FrameRecording open(int width, int height) const {
    sensor::SensorDescription sensor;
    sensor.depth = {width, height, 58, 58, 0.5 * width, 0.5 * height, {}};
    auto recording = FrameRecording::open(folder_.file("a.oni"), sensor, "left");
    EXPECT_TRUE(recording);
    return std::move(*recording);
  }

  static RgbdFrame frame(int i, int width, int height) {
    RgbdFrame frame;
    frame.metadata.sequence = static_cast<std::uint64_t>(i + 1);
    frame.depth = DepthImage(width, height);
    for (std::size_t at = 0; at < frame.depth.pixels().size(); ++at) {  // noise: slow to code
      frame.depth.data()[at] = static_cast<std::uint16_t>(
          (static_cast<unsigned>(at) + static_cast<unsigned>(i)) * 2654435761u >> 20);
    }
    frame.sensor_times.depth = microseconds(33'333 * i);
    return frame;
  }

  std::size_t recorded() const {
    const auto summary = recording::check(folder_.file("a.oni"));
    EXPECT_TRUE(summary) << summary.error().what;
    return summary ? summary->find(Kind::kDepth)->frames() : 0;
  }

  const test::TemporaryFolder folder_;
};

TEST_F(RecordingThreadTest, CountsWhatADiskThatIsTooSlowLeavesOutAndBlocksNobody) {
  constexpr int kFrames = 150;
  std::uint64_t left_out = 0;
  {
    RecordingThread thread(open(320, 240));
    const RgbdFrame same = frame(0, 320, 240);
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < kFrames; ++i) {
      RgbdFrame next = same;
      next.sensor_times.depth = microseconds(33'333 * i);
      thread.offer(next, false, {});
    }
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
    thread.end(milliseconds(5000));
    left_out = thread.left_out();
  }
  EXPECT_GT(left_out, 0u) << "the queue was never full: nothing is tested here";
  EXPECT_EQ(recorded() + left_out, static_cast<std::size_t>(kFrames));
}

TEST_F(RecordingThreadTest, LosesNothingOfASourceThatCanWait) {
  {
    RecordingThread thread(open(64, 48));
    for (int i = 0; i < 200; ++i) thread.offer(frame(i, 64, 48), true, {});
    thread.end(milliseconds(5000));
    EXPECT_EQ(thread.left_out(), 0u);
  }
  EXPECT_EQ(recorded(), 200u);
}

TEST_F(RecordingThreadTest, EndsWithAWholeFileWhenTheFileMayNotGrow) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::uint64_t left_out = 0;
  {
    RecordingThread thread(open(64, 48));
    rlimit small = before;
    small.rlim_cur = 40'000;
    setrlimit(RLIMIT_FSIZE, &small);
    for (int i = 0; i < 100; ++i) thread.offer(frame(i, 64, 48), true, {});
    thread.end(milliseconds(5000));
    while (thread.left_out() == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  left_out = 100 - recorded();
  EXPECT_GT(left_out, 0u);
  EXPECT_LT(left_out, 100u);
}

}  // namespace
}  // namespace copresence::server
