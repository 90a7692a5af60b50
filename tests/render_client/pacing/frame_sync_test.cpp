#include "render_client/pacing/frame_sync.h"

#include <gtest/gtest.h>

namespace copresence::pacing {
namespace {

using std::chrono::milliseconds;

Instant at(int ms) {
  return Instant(milliseconds(1000 + ms));
}

class FrameSyncTest : public ::testing::Test {
 protected:
  void arrives(std::size_t camera, std::uint64_t sequence, int captured_ms, int arrived_ms) {
    client::CameraFrame received;
    received.frame.metadata.sequence = sequence;
    received.captured_at = at(captured_ms);
    received.arrived_at = at(arrived_ms);
    received.stream = stream_;
    mailboxes_.put(camera, std::move(received));
  }
  std::uint64_t taken(FrameSync& frames, std::size_t camera) {
    const auto received = frames.take(camera);
    return received ? received->frame.metadata.sequence : 0;
  }

  std::shared_ptr<const StreamDescription> stream_ = std::make_shared<StreamDescription>();
  flow::Mailboxes<client::CameraFrame> mailboxes_{2};
  std::vector<int> passed_over_ = std::vector<int>(2);
  std::function<void(std::size_t)> count_ = [this](std::size_t camera) { ++passed_over_[camera]; };
};

TEST_F(FrameSyncTest, HandsEveryFrameOnAtOnceWhereNobodyAsksForMore) {
  FrameSync frames(2, false, count_);
  arrives(0, 1, 0, 20);
  frames.gather(mailboxes_, at(20));
  EXPECT_EQ(taken(frames, 0), 1u);
  EXPECT_EQ(taken(frames, 0), 0u);
  EXPECT_EQ(taken(frames, 1), 0u);
  EXPECT_EQ(frames.wake_by(at(100)), at(100));
}

TEST_F(FrameSyncTest, HoldsAFrameUntilItsNeighbourIsThere) {
  FrameSync frames(2, true, count_);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 13, 33);
  frames.gather(mailboxes_, at(33));
  EXPECT_EQ(taken(frames, 0), 1u);
  EXPECT_EQ(taken(frames, 1), 1u);
  arrives(0, 2, 33, 53);  // 20 ms from the frame on view of the other camera, 13 ms from its next one
  frames.gather(mailboxes_, at(53));
  EXPECT_EQ(taken(frames, 0), 0u);
  EXPECT_LE(frames.wake_by(at(500)), at(53 + 17));
  arrives(1, 2, 46, 66);
  frames.gather(mailboxes_, at(66));
  const auto held = frames.take(0);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->frame.metadata.sequence, 2u);
  EXPECT_EQ(held->arrived_at, at(66));
  EXPECT_EQ(taken(frames, 1), 2u);
}

TEST_F(FrameSyncTest, LetsGoAfterHalfAPeriod) {
  FrameSync frames(2, true, count_);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 13, 33);
  frames.gather(mailboxes_, at(33));
  frames.take(0);
  frames.take(1);
  arrives(0, 2, 33, 53);
  frames.gather(mailboxes_, at(53));
  frames.gather(mailboxes_, at(71));
  EXPECT_EQ(taken(frames, 0), 2u);
}

TEST_F(FrameSyncTest, WaitsForNobodyWhoStopped) {
  FrameSync frames(2, true, count_);
  arrives(0, 1, 0, 20);
  arrives(1, 1, 0, 20);
  frames.gather(mailboxes_, at(20));
  frames.take(0);
  frames.take(1);
  for (int i = 2; i < 10; ++i) {
    const int arrived = 33 * i - 13;
    arrives(0, static_cast<std::uint64_t>(i), 33 * (i - 1), arrived);
    frames.gather(mailboxes_, at(arrived));
    if (i > 5) {
      EXPECT_EQ(taken(frames, 0), static_cast<std::uint64_t>(i)) << "at once";
    } else {
      frames.gather(mailboxes_, at(arrived + 17));
      frames.take(0);
    }
  }
}

TEST_F(FrameSyncTest, CountsFramesThatItPassesOver) {
  FrameSync frames(2, true, count_);
  arrives(0, 1, 0, 20);
  frames.gather(mailboxes_, at(20));
  arrives(0, 2, 33, 53);
  frames.gather(mailboxes_, at(53));  // the first frame was not taken
  EXPECT_EQ(taken(frames, 0), 2u);
  EXPECT_EQ(passed_over_[0], 1);
}

TEST_F(FrameSyncTest, FollowsAServerThatBeginsAnewWithAnEarlierClock) {
  FrameSync frames(2, true, count_);
  arrives(0, 900, 5000, 5020);
  frames.gather(mailboxes_, at(5020));
  EXPECT_EQ(taken(frames, 0), 900u);
  arrives(0, 1, 100, 5100);
  frames.gather(mailboxes_, at(5100));
  EXPECT_EQ(taken(frames, 0), 1u);
}

/// Two cameras of different rates, and a client that polls every millisecond.
struct DifferentRates {
  int slow_period_ms = 200, slow_phase_ms = 0;
  double announced_by_slow = 5;

  double worst_skew_ms = 0, worst_wait_ms = 0;
  int fast_views = 0, slow_views = 0;

  void run(int until_ms) {
    auto fast_stream = std::make_shared<StreamDescription>(),
         slow_stream = std::make_shared<StreamDescription>();
    slow_stream->frames_per_second = announced_by_slow;
    flow::Mailboxes<client::CameraFrame> mailboxes(2);
    FrameSync frames(2, true, [](std::size_t) {});
    std::optional<Instant> shown[2];
    for (int now = 0; now < until_ms; ++now) {
      const auto deliver = [&](std::size_t camera, int period, int phase, const auto& stream) {
        const int captured = now - 20;
        if (captured < phase || (captured - phase) % period != 0) return;
        client::CameraFrame received;
        received.captured_at = at(captured);
        received.arrived_at = at(now);
        received.stream = stream;
        mailboxes.put(camera, std::move(received));
      };
      deliver(0, 33, 0, fast_stream);
      deliver(1, slow_period_ms, slow_phase_ms, slow_stream);
      frames.gather(mailboxes, at(now));
      bool is_new = false;
      for (std::size_t camera : {0u, 1u}) {
        const auto taken = frames.take(camera);
        if (!taken) continue;
        is_new = true;
        shown[camera] = taken->captured_at;
        ++(camera ? slow_views : fast_views);
        if (now < 1500) continue;
        worst_wait_ms = std::max(worst_wait_ms, in_ms(at(now - 20) - taken->captured_at));
      }
      if (is_new && shown[0] && shown[1] && now > 1500)
        worst_skew_ms = std::max(worst_skew_ms, in_ms(std::chrono::abs(*shown[0] - *shown[1])));
    }
  }
  static double in_ms(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
  }
};

TEST(FrameSyncOfDifferentRates, KeepsTheSlowCameraInAllTheTime) {
  for (int phase = 0; phase < 200; phase += 23) {
    DifferentRates room{.slow_phase_ms = phase};
    room.run(6000);
    EXPECT_LE(room.worst_skew_ms, 117) << "half a period of the slow camera, and a frame of the fast one";
    EXPECT_LE(room.worst_wait_ms, 101) << phase;
    EXPECT_GE(room.slow_views, 28) << phase;
    EXPECT_GE(room.fast_views, 80) << phase;
  }
}

TEST(FrameSyncOfDifferentRates, MeasuresARateThatIsNotTheAnnouncedOne) {
  DifferentRates room{.announced_by_slow = 30};
  room.run(6000);
  EXPECT_LE(room.worst_skew_ms, 117);
  EXPECT_GE(room.slow_views, 28);
}

TEST(FrameSyncOfDifferentRates, WaitsForNoneThatComesEverySecond) {
  for (const double announced : {1.0, 30.0}) {
    DifferentRates room{.slow_period_ms = 1000, .announced_by_slow = announced};
    room.run(12'000);
    EXPECT_GE(room.fast_views, 330) << announced;
    EXPECT_GE(room.slow_views, 10) << announced;
  }
}

}  // namespace
}  // namespace copresence::pacing
