// Windows and encoder demand over simulated links: what clients get, how late, and what they cost each other.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/common/wire/flow_control/simulated_links.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::Ge;
using testing::Le;

constexpr double kFullRate = 29.7;  // a path may have to run empty once
const Link kNear{0, 1ms};

/// Keyframes of twice the size of other frames, as the demo's, and of four times.
class FlowControl : public testing::TestWithParam<double> {
 protected:
  SimulatedNetwork network{Stream{.keyframe = GetParam()}};
};
INSTANTIATE_TEST_SUITE_P(Keyframes, FlowControl, testing::Values(2.0, 4.0));

TEST_P(FlowControl, CarriesEverythingOverAWidePathHoweverLongItIs) {
  for (const Duration delay :
       {Duration(0ms), Duration(25ms), Duration(100ms), Duration(200ms), Duration(400ms)}) {
    for (const bool with_another : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      if (with_another) fresh.join(kNear);
      const auto& client = fresh.join({0, delay});
      fresh.run_for(20s);
      EXPECT_GE(client.rate(5s, 20s), kFullRate) << delay.count();
      EXPECT_LE(client.delay(5s, 20s, 0.99), delay + 5ms);
    }
  }
}

TEST_P(FlowControl, IsAtFullRateSoonAfterAPathGrewLonger) {
  struct Change {
    Duration from, to;
  };
  for (const auto& [from, to] :
       {Change{5ms, 90ms}, {5ms, 30ms}, {5ms, 40ms}, {20ms, 60ms}, {5ms, 150ms}, {5ms, 300ms}, {90ms, 5ms}}) {
    for (const bool with_another : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      auto& client = fresh.join({0, from});
      const auto* another = with_another ? &fresh.join(kNear) : nullptr;
      fresh.run_for(8s);
      fresh.change(client, {0, to});
      fresh.run_for(20s);
      EXPECT_GE(client.rate(11s, 28s), kFullRate)
          << from.count() << " to " << to.count() << ", another: " << with_another;
      EXPECT_GE(client.rate(8s, 11s), 15) << "meanwhile";
      EXPECT_LE(client.delay(11s, 28s, 0.99), to + 5ms);
      if (another) {
        EXPECT_GE(another->rate(2s, 28s), kFullRate);
        EXPECT_LE(another->keyframes_per_second(8s, 28s), 0.1) << "one at most";
      }
    }
  }
}

TEST_P(FlowControl, FollowsAPathThatGetsNarrowerAndWiderAgain) {
  auto& client = network.join(kNear);
  network.run_for(5s);
  network.change(client, {4, 1ms});
  network.run_for(15s);
  EXPECT_THAT(client.rate(8s, 20s), AllOf(Ge(13), Le(15)));
  EXPECT_LE(client.delay(8s, 20s, 0.95), 250ms);
  network.change(client, kNear);
  network.run_for(10s);
  EXPECT_GE(client.rate(22s, 30s), kFullRate);
  EXPECT_LE(client.delay(22s, 30s, 0.95), 5ms);
}

TEST_P(FlowControl, GivesANarrowPathUsefulFramesBesideAFastClient) {
  struct Case {
    double megabits_per_second, least_rate;
    Duration most_delay;
  };
  for (const auto& [megabits_per_second, least_rate, most_delay] :
       {Case{6, 15, 600ms}, {4, 5, 600ms}, {2, 1.4, 800ms}}) {
    for (const bool from_the_start : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      auto& fast = fresh.join(kNear);
      fresh.run_for(2s);
      auto& slow = fresh.join(from_the_start ? Link{megabits_per_second, 1ms} : kNear);
      fresh.run_for(5s);
      fresh.change(slow, {megabits_per_second, 1ms});
      fresh.run_for(53s);
      EXPECT_GE(slow.rate(10s, 60s), least_rate)
          << megabits_per_second << " Mbit/s, from the start: " << from_the_start;
      EXPECT_LE(slow.delay(10s, 60s, 0.95), most_delay) << megabits_per_second;
      EXPECT_GE(fast.rate(2s, 60s), kFullRate) << "it loses nothing";
      EXPECT_LE(fast.delay(2s, 60s, 0.99), 5ms);
    }
  }
}

/// A path that carries less than one keyframe a second beside a fast client: it gets keyframes only, as many as it
/// carries or as the encoder's share for slow clients allows.
TEST_P(FlowControl, FillsAVeryNarrowPathWithKeyframes) {
  for (const double megabits_per_second : {1.0, 0.5, 0.25}) {
    for (const bool from_the_start : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      auto& fast = fresh.join(kNear);
      auto& slow = fresh.join(from_the_start ? Link{megabits_per_second, 1ms} : kNear);
      fresh.run_for(5s);
      fresh.change(slow, {megabits_per_second, 1ms});
      fresh.run_for(115s);
      const double keyframe_s = 34000 * GetParam() * 8e-6 / megabits_per_second;
      const double allowed_s = (GetParam() - 1) / 0.05 / 30;
      EXPECT_GE(slow.keyframes_per_second(20s, 120s), 0.9 / std::max({1.0, keyframe_s, allowed_s}))
          << megabits_per_second << " Mbit/s, from the start: " << from_the_start;
      EXPECT_LE(slow.delay(20s, 120s, 1),
                std::max<Duration>(800ms, std::chrono::duration_cast<Duration>(
                                              1.02 * std::chrono::duration<double>(keyframe_s))))
          << megabits_per_second;
      EXPECT_GE(fast.rate(2s, 120s), kFullRate);
    }
  }
}

/// A free path is cut in mid-stream. What is on its way then arrives late, once.
TEST_P(FlowControl, IsLateOnceWhenAPathCollapses) {
  struct Case {
    double megabits_per_second;
    Duration alone, beside_another;
  };
  for (const auto& [megabits_per_second, alone, beside_another] :
       {Case{4, 300ms, 600ms}, {2, 450ms, 800ms}, {1, 1000ms, 1500ms}, {0.5, 2100ms, 3100ms}}) {
    for (const bool with_another : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      if (with_another) fresh.join(kNear);
      auto& client = fresh.join(kNear);
      fresh.run_for(5s);
      fresh.change(client, {megabits_per_second, 1ms});
      fresh.run_for(20s);
      EXPECT_LE(client.delay(5s, 25s, 1), with_another ? beside_another : alone)
          << megabits_per_second << " Mbit/s, another: " << with_another;
    }
  }
}

TEST_P(FlowControl, SpendsATwentiethOfTheStreamOnKeyframesForSlowClients) {
  auto& fast = network.join(kNear);
  for (int i = 0; i < 5; ++i) network.join({0.5 + i, 20ms});
  network.run_for(120s);
  const double extra_frames = fast.keyframes_per_second(20s, 120s) * (GetParam() - 1);
  EXPECT_LE(extra_frames, 30 * 0.055);
  EXPECT_GE(fast.rate(5s, 120s), kFullRate);
}

TEST_P(FlowControl, IsNeverSecondsLateAfterJoiningOverANarrowPath) {
  struct Case {
    double megabits_per_second, least_rate;
    Duration most_delay;
  };
  for (const auto& [megabits_per_second, least_rate, most_delay] :
       {Case{4, 13, 250ms}, {2, 5.5, 350ms}, {1, 3, 350ms}, {0.5, 1.6, 650ms}}) {
    SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
    const auto& client = fresh.join({megabits_per_second, 1ms});
    fresh.run_for(60s);
    EXPECT_GE(client.rate(10s, 60s), least_rate) << megabits_per_second << " Mbit/s";
    EXPECT_LE(client.delay(10s, 60s, 0.95), most_delay) << megabits_per_second << " Mbit/s";
    EXPECT_LE(client.delay(0s, 60s, 1), 10 * most_delay) << "the beginning, too";
  }
}

TEST_P(FlowControl, ShowsAJoiningClientAPictureAtOnce) {
  network.join(kNear);
  network.run_for(10s);
  const auto& client = network.join({0, 50ms});
  network.run_for(1s);
  ASSERT_FALSE(client.arrivals().empty());
  EXPECT_LE(client.arrivals().front().at, 10s + 50ms + 40ms);
}

TEST_P(FlowControl, ToleratesJitter) {
  struct Case {
    Duration delay, jitter;
  };
  for (const auto& [delay, jitter] : {Case{5ms, 40ms}, {5ms, 80ms}, {90ms, 40ms}, {200ms, 40ms}}) {
    for (const bool with_another : {false, true}) {
      SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
      if (with_another) fresh.join({0, delay, jitter});
      const auto& client = fresh.join({0, delay, jitter});
      fresh.run_for(60s);
      EXPECT_GE(client.rate(2s, 60s), 29.5) << delay.count() << " +- " << jitter.count();
    }
  }
}

TEST_P(FlowControl, IsNoLaterAfterAnHour) {
  for (const double megabits_per_second : {4.0, 8.0, 8.1, 8.2}) {
    SimulatedNetwork fresh(Stream{.keyframe = GetParam()});
    const auto& client = fresh.join({megabits_per_second, 20ms});
    fresh.run_for(3600s);
    EXPECT_LE(client.delay(3500s, 3600s, 0.95), client.delay(10s, 110s, 0.95) + 50ms) << megabits_per_second;
    EXPECT_LE(client.delay(3500s, 3600s, 0.95), 350ms);
  }
}

TEST_P(FlowControl, ForgetsAStall) {
  auto& client = network.join({0, 20ms});
  network.run_for(10s);
  network.change(client, {0.001, 20ms});
  network.run_for(2s);
  network.change(client, {0, 20ms});
  network.run_for(20s);
  EXPECT_GE(client.rate(14s, 32s), kFullRate);
  EXPECT_LE(client.delay(14s, 32s, 0.99), 25ms);
}

TEST_P(FlowControl, LosesNoFrameToAHiccup) {
  auto& client = network.join({0, 5ms});
  network.run_for(10s);
  network.change(client, {0.001, 5ms});
  network.run_for(200ms);
  network.change(client, {0, 5ms});
  network.run_for(5s);
  EXPECT_GE(client.rate(10s, 15s), kFullRate - 0.3);
}

TEST_P(FlowControl, MovesOnWhenAStillSceneBeginsToMove) {
  SimulatedNetwork fresh(Stream{.frame_bytes = 3000, .keyframe = 10 * GetParam()});
  const auto& client = fresh.join({0, 100ms});
  fresh.run_for(30s);
  fresh.change(Stream{.keyframe = GetParam()});
  fresh.run_for(10s);
  EXPECT_GE(client.rate(5s, 30s), kFullRate);
  EXPECT_GE(client.rate(32s, 40s), kFullRate);
}

TEST_P(FlowControl, HoldsNoMoreThanItsBoundsForAClientThatNeverAcknowledges) {
  network.join(kNear);
  auto& dead = network.join({0, 1ms});
  network.run_for(5s);
  network.change(dead, {1e-6, 1ms});
  network.run_for(60s);
  EXPECT_LE(dead.window().bytes_in_flight(), ClientWindow::kBytes);
  EXPECT_LE(dead.window().frames_in_flight(), 30u);
}

TEST_P(FlowControl, LetsTwoEquallySlowClientsShareAnEncoder) {
  const auto& one = network.join({4, 1ms});
  const auto& other = network.join({4, 30ms});
  network.run_for(60s);
  for (const auto* client : {&one, &other}) {
    EXPECT_GE(client->rate(10s, 60s), 12);
    EXPECT_LE(client->delay(10s, 60s, 0.95), 400ms);
  }
}

}  // namespace
}  // namespace copresence::wire
