#include "render_client/session/playback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "render_client/session/session_writer.h"
#include "tests/render_client/session/coded_stream.h"
#include "tests/support/process.h"

namespace copresence::session {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Two cameras with a frame each 100 ms and a keyframe each 500 ms. The right one joins after 1 s.
class PlaybackTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string path = (folder_ / "a.mkv").string();
    const Instant began = Instant(std::chrono::hours(5));
    auto writer = SessionWriter::create(path, began);
    ASSERT_TRUE(writer);
    CodedStream left("left"), right("right");
    for (int i = 0; i < 20; ++i) {
      ASSERT_TRUE(writer->write(0, left.description(), left.next(i % 5 == 0), began + i * milliseconds(100)));
      if (i < 10) continue;
      ASSERT_TRUE(writer->write(1, right.description(), right.next(false), began + i * milliseconds(100)));
    }
    ASSERT_TRUE(writer->finish());
    auto file = SessionFile::open(path);
    ASSERT_TRUE(file);
    playback_.emplace(std::move(*file));
    for (std::size_t camera = 0; camera < 2; ++camera) {
      threads_.emplace_back([this, camera](const std::stop_token& stop) { receive(camera, stop); });
    }
  }
  void TearDown() override {
    for (std::jthread& thread : threads_) thread.request_stop();
    threads_.clear();
  }

  /// Receives frames as the client does, over any number of connections.
  void receive(std::size_t camera, const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      auto source = playback_->connect(camera, stop);
      if (!source) return;
      for (;;) {
        const auto received = (*source)->next(stop, std::chrono::steady_clock::now() + milliseconds(50));
        const std::lock_guard lock(mutex_);
        if (received) {
          taken_[camera].push_back(received->frame.sequence);
          const Instant captured_at = (*source)->clock().to_local(received->sent_at);
          EXPECT_EQ(captured_at, received->received_at);
        } else if (received.error().code == ErrorCode::kEndOfStream) {
          ends_[camera].push_back(received.error().what);
          break;
        } else if (received.error().code != ErrorCode::kTimeout) {
          return;
        }
      }
    }
  }

  /// The sequences of the frames that a camera has given since the last call.
  std::vector<std::uint64_t> taken(std::size_t camera) {
    playback_->wait_until_taken({});
    const std::lock_guard lock(mutex_);
    return std::exchange(taken_[camera], {});
  }

  copresence::testing::TemporaryFolder folder_;
  std::optional<Playback> playback_;
  std::mutex mutex_;
  std::vector<std::uint64_t> taken_[2];
  std::vector<std::string> ends_[2];
  std::vector<std::jthread> threads_;
};

TEST_F(PlaybackTest, GivesExactlyTheFramesUpToThePosition) {
  EXPECT_THAT(taken(0), IsEmpty());
  playback_->advance(Time(0));
  EXPECT_THAT(taken(0), ElementsAre(1));
  playback_->advance(Time(2999));
  EXPECT_THAT(taken(0), ElementsAre(2, 3));
  playback_->advance(Time(3000));
  EXPECT_THAT(taken(0), ElementsAre(4));
  EXPECT_THAT(taken(1), IsEmpty());
  EXPECT_EQ(playback_->now(), Playback::instant(Time(3000)));
}

TEST_F(PlaybackTest, ACameraThatJoinedLaterJoinsTheReplayThen) {
  playback_->advance(Time(9999));
  EXPECT_THAT(taken(1), IsEmpty());
  playback_->advance(Time(10'000));
  EXPECT_THAT(taken(1), ElementsAre(1));
}

TEST_F(PlaybackTest, TheEndIsThatOfARecordingAndASeekGoesBehindIt) {
  playback_->advance(Time(30'000));
  EXPECT_EQ(taken(0).size(), 20u);
  EXPECT_EQ(taken(1).size(), 10u);
  EXPECT_THAT(ends_[0], ElementsAre("the recording is over"));
  playback_->seek(Time(17'500));
  EXPECT_THAT(taken(0), ElementsAre(16, 17, 18)) << "from the keyframe before the position";
}

TEST_F(PlaybackTest, ASeekBackGoesOnWithTheKeyframeBefore) {
  playback_->advance(Time(9000));
  taken(0);
  playback_->seek(Time(7200));
  EXPECT_THAT(taken(0), ElementsAre(6, 7, 8));
  playback_->advance(Time(8000));
  EXPECT_THAT(taken(0), ElementsAre(9));
}

TEST_F(PlaybackTest, ASeekForwardLeavesOutTheFramesBeforeTheKeyframe) {
  playback_->advance(Time(0));
  taken(0);
  playback_->seek(Time(11'000));
  EXPECT_THAT(taken(0), ElementsAre(11, 12));
  playback_->seek(Time(13'000));
  EXPECT_THAT(taken(0), ElementsAre(13, 14)) << "within a group of pictures it goes on";
}

TEST_F(PlaybackTest, KnowsTheNextFrameOfAnyCamera) {
  EXPECT_EQ(playback_->next_frame_after(Time(-1)), Time(0));
  EXPECT_EQ(playback_->next_frame_after(Time(0)), Time(1000));
  EXPECT_EQ(playback_->next_frame_after(Time(19'000)), std::nullopt);
}

}  // namespace
}  // namespace copresence::session
