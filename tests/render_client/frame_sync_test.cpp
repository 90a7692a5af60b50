#include "render_client/frame_sync.h"

#include <gtest/gtest.h>

namespace copresence::client {
namespace {

using std::chrono::milliseconds;

Instant at(int ms) {
  return Instant(milliseconds(1000 + ms));
}

class FrameSyncTest : public ::testing::Test {
 protected:
  void arrives(std::size_t camera, std::uint64_t sequence, int captured_ms, int arrived_ms) {
    Received received;
    received.frame.stamp.sequence = sequence;
    received.captured_at = at(captured_ms);
    received.arrived_at = at(arrived_ms);
    received.stream = stream_;
    board_.put(camera, std::move(received));
  }
  std::uint64_t taken(FrameSync& frames, std::size_t camera) {
    const auto received = frames.take(camera);
    return received ? received->frame.stamp.sequence : 0;
  }

  std::shared_ptr<const StreamDescription> stream_ = std::make_shared<StreamDescription>();
  flow::LatestOfEach<Received> board_{2};
  std::deque<CameraStatistics> statistics_ = std::deque<CameraStatistics>(2);
};

TEST_F(FrameSyncTest, HandsEveryFrameOnAtOnceWhereNobodyAsksForMore) {
  FrameSync frames(2, false);
  arrives(0, 1, 0, 20);
  frames.gather(board_, statistics_, at(20));
  EXPECT_EQ(taken(frames, 0), 1u);
  EXPECT_EQ(taken(frames, 0), 0u);
  EXPECT_EQ(taken(frames, 1), 0u);
  EXPECT_EQ(frames.wake_by(at(100)), at(100));
}

TEST_F(FrameSyncTest, HoldsAFrameUntilItsNeighbourIsThere) {
  FrameSync frames(2, true);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 13, 33);
  frames.gather(board_, statistics_, at(33));
  EXPECT_EQ(taken(frames, 0), 1u);
  EXPECT_EQ(taken(frames, 1), 1u);
  arrives(0, 2, 33, 53);  // 20 ms from what the other camera shows, 13 from what comes
  frames.gather(board_, statistics_, at(53));
  EXPECT_EQ(taken(frames, 0), 0u);
  EXPECT_LE(frames.wake_by(at(500)), at(53 + 17));
  arrives(1, 2, 46, 66);
  frames.gather(board_, statistics_, at(66));
  const auto held = frames.take(0);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->frame.stamp.sequence, 2u);
  EXPECT_EQ(held->arrived_at, at(66));
  EXPECT_EQ(taken(frames, 1), 2u);
}

TEST_F(FrameSyncTest, LetsGoAfterHalfAPeriod) {
  FrameSync frames(2, true);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 13, 33);
  frames.gather(board_, statistics_, at(33));
  frames.take(0);
  frames.take(1);
  arrives(0, 2, 33, 53);
  frames.gather(board_, statistics_, at(53));
  frames.gather(board_, statistics_, at(71));
  EXPECT_EQ(taken(frames, 0), 2u);
}

TEST_F(FrameSyncTest, WaitsForNobodyWhoStopped) {
  FrameSync frames(2, true);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 0, 20);
  frames.gather(board_, statistics_, at(20));
  frames.take(0);
  frames.take(1);
  for (int i = 2; i < 10; ++i) {
    const int arrived = 33 * i - 13;
    arrives(0, static_cast<std::uint64_t>(i), 33 * (i - 1), arrived);
    frames.gather(board_, statistics_, at(arrived));
    if (i > 5) {
      EXPECT_EQ(taken(frames, 0), static_cast<std::uint64_t>(i)) << "at once";
    } else {
      frames.gather(board_, statistics_, at(arrived + 17));
      frames.take(0);
    }
  }
}

TEST_F(FrameSyncTest, CountsFramesThatItPassesOver) {
  FrameSync frames(2, true);
  arrives(0, 1, 0, 20);
  frames.gather(board_, statistics_, at(20));
  arrives(0, 2, 33, 53);
  frames.gather(board_, statistics_, at(53));  // nobody took the first
  EXPECT_EQ(taken(frames, 0), 2u);
  EXPECT_EQ(statistics_[0].snapshot().unshown, 1u);
}

TEST_F(FrameSyncTest, FollowsAServerThatBeginsAnewWithAnEarlierClock) {
  FrameSync frames(2, true);
  arrives(0, 900, 5000, 5020);
  frames.gather(board_, statistics_, at(5020));
  EXPECT_EQ(taken(frames, 0), 900u);
  arrives(0, 1, 100, 5100);
  frames.gather(board_, statistics_, at(5100));
  EXPECT_EQ(taken(frames, 0), 1u);
}

}  // namespace
}  // namespace copresence::client
