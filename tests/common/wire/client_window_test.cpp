#include "common/wire/client_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kSmall = 1000;
constexpr Duration kPeriod = 33ms;
const Instant kNow{};

/// A window whose client joined with frame 1 and has `last` frames in flight.
ClientWindow with_frames_in_flight(std::uint64_t last) {
  ClientWindow window(kPeriod);
  for (std::uint64_t sequence = 1; sequence <= last; ++sequence) window.sent(sequence, kSmall, kNow);
  return window;
}

TEST(ClientWindow, BeginsWithAKeyframe) {
  ClientWindow window(kPeriod);
  EXPECT_FALSE(window.may_have(false));
  EXPECT_TRUE(window.may_have(true));
}

TEST(ClientWindow, TakesSoManyFramesAndNoMore) {
  const ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  EXPECT_FALSE(window.has_room());
  EXPECT_FALSE(window.may_have(true));
}

TEST(ClientWindow, TakesSoManyBytesAndNoMore) {
  ClientWindow window(kPeriod);
  window.sent(1, ClientWindow::kBytes - 1, kNow);
  EXPECT_TRUE(window.has_room());
  window.sent(2, kSmall, kNow);
  EXPECT_FALSE(window.has_room());
  ASSERT_TRUE(window.acknowledge(1, kNow));
  EXPECT_TRUE(window.has_room());
  EXPECT_EQ(window.bytes_in_flight(), kSmall);
}

TEST(ClientWindow, GoesOnWithoutAKeyframeWhenNothingWasSkipped) {
  ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  ASSERT_TRUE(window.acknowledge(1, kNow));
  EXPECT_TRUE(window.may_have(false));
}

TEST(ClientWindow, WaitsForAKeyframeOnceItSkipped) {
  ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  window.skip(1);
  ASSERT_TRUE(window.acknowledge(ClientWindow::kFrames - 1, kNow));
  EXPECT_FALSE(window.has_room()) << "a frame is still in flight";
  ASSERT_TRUE(window.acknowledge(ClientWindow::kFrames, kNow));
  EXPECT_TRUE(window.has_room());
  EXPECT_FALSE(window.may_have(false));
  EXPECT_TRUE(window.may_have(true));
  window.sent(20, kSmall, kNow);
  EXPECT_TRUE(window.may_have(false));
  EXPECT_EQ(window.skipped(), 1u);
}

TEST(ClientWindow, AcknowledgesEverythingUpToAFrame) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_TRUE(window.acknowledge(3, kNow));
  EXPECT_EQ(window.frames_in_flight(), 2u);
  EXPECT_EQ(window.bytes_in_flight(), 2 * kSmall);
}

TEST(ClientWindow, BelievesNoAcknowledgementOfAFrameThatIsNotInFlight) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_FALSE(window.acknowledge(6, kNow));
  EXPECT_TRUE(window.acknowledge(2, kNow));
  EXPECT_FALSE(window.acknowledge(2, kNow)) << "twice";
  EXPECT_FALSE(window.acknowledge(0, kNow));
}

/// A path that carries one frame per `service` after the other and takes `round_trip` beside, and what
/// becomes of a stream with one client on it; the encoder pauses when there is no room.
struct Path {
  Duration service, round_trip;
  Duration stall{};  // once, in the tenth second

  struct Outcome {
    double frames_per_second = 0;
    Duration worst_lag{};  // in the second half
  };
  Outcome carry(std::chrono::seconds duration) const {
    ClientWindow window(kPeriod);
    std::deque<std::pair<std::uint64_t, Instant>> acks;
    Instant free{};
    Outcome outcome;
    std::uint64_t sent = 0;
    for (Instant now{}; now < Instant{} + duration; now += kPeriod) {
      for (; !acks.empty() && acks.front().second <= now; acks.pop_front()) {
        EXPECT_TRUE(window.acknowledge(acks.front().first, acks.front().second));
      }
      if (!window.has_room()) continue;
      window.sent(++sent, kSmall, now);
      const bool stalls = now <= Instant{} + 10s && now + kPeriod > Instant{} + 10s;
      free = std::max(free, now) + service + (stalls ? stall : Duration::zero());
      acks.emplace_back(sent, free + round_trip);
      if (now > Instant{} + duration / 2)
        outcome.worst_lag = std::max(outcome.worst_lag, acks.back().second - now);
    }
    outcome.frames_per_second = static_cast<double>(sent) / static_cast<double>(duration.count());
    return outcome;
  }
};

TEST(ClientWindow, LetsAWidePathCarryEverythingHoweverLongItIs) {
  for (const Duration round_trip : {0ms, 50ms, 200ms}) {
    EXPECT_GT((Path{5ms, round_trip}.carry(20s).frames_per_second), 30);
  }
}

TEST(ClientWindow, KeepsLagShortOnAPathThatCarriesLessThanTheStream) {
  const Path::Outcome half = Path{66ms, 1ms}.carry(60s);
  EXPECT_GT(half.frames_per_second, 14.5);
  EXPECT_LE(half.worst_lag, 300ms) << "8 frames would be 530 ms old";
  const Path::Outcome far = Path{66ms, 100ms}.carry(60s);
  EXPECT_GT(far.frames_per_second, 14.5);
  EXPECT_LE(far.worst_lag, 480ms);
}

TEST(ClientWindow, DoesNotLagMoreAfterAnHour) {
  const Path slow{50ms, 30ms};
  EXPECT_LE(slow.carry(3600s).worst_lag, slow.carry(60s).worst_lag);
}

TEST(ClientWindow, ForgetsAStall) {
  const Path stalls{5ms, 20ms, 2s};
  EXPECT_EQ(stalls.carry(60s).worst_lag, 25ms);
  EXPECT_GT(stalls.carry(60s).frames_per_second, 28.5);
}

}  // namespace
}  // namespace copresence::wire
