#include "common/wire/clock_offset.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

constexpr auto kAhead = 1000s;  // the server's clock before the client's

TEST(ClockOffset, IsExactOnASymmetricPath) {
  ClockEstimate estimate;
  estimate.add(at_ns(0), at_ns(500'000) + kAhead, at_ns(1'000'000));
  const ClockOffset clock = estimate.at(at_ns(1'000'000));
  EXPECT_EQ(clock.offset, kAhead);
  EXPECT_EQ(clock.uncertainty, 500us);
  EXPECT_EQ(clock.to_local(at_ns(7) + kAhead), at_ns(7));
}

TEST(ClockOffset, TrustsTheQuickestPing) {
  ClockEstimate estimate;
  estimate.add(at_ns(0) + 10ms, at_ns(0) + 39ms + kAhead, at_ns(0) + 40ms);  // slow there, quick back
  estimate.add(at_ns(0) + 50ms, at_ns(0) + 51ms + kAhead, at_ns(0) + 52ms);
  estimate.add(at_ns(0) + 60ms, at_ns(0) + 61ms + kAhead, at_ns(0) + 90ms);
  EXPECT_EQ(estimate.at(at_ns(0) + 90ms).offset, kAhead);
}

TEST(ClockOffset, StatesABoundThatHoldsWhateverThePathDoes) {
  std::mt19937 random(5);
  std::exponential_distribution<double> delay_ms(0.2);
  ClockEstimate estimate;
  Instant now = at_ns(0);
  for (int i = 0; i < 300; ++i) {
    now += 1s;
    const double drift_s = 5e-5 * std::chrono::duration<double>(now.time_since_epoch()).count();
    const Duration truth = kAhead + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * drift_s));
    const auto there = std::chrono::microseconds(static_cast<int>(1000 * delay_ms(random)));
    const auto back = std::chrono::microseconds(static_cast<int>(1000 * delay_ms(random)));
    estimate.add(now, now + there + truth, now + there + back);
    const ClockOffset clock = estimate.at(now + there + back);
    EXPECT_LE(std::chrono::abs(clock.offset - truth), clock.uncertainty) << "after ping " << i;
    EXPECT_TRUE(i < 30 || clock.uncertainty < 6ms) << "after ping " << i;
  }
}

TEST(ClockOffset, PrefersAFreshPingToAnOldSlightlyQuickerOne) {
  ClockEstimate estimate;
  estimate.add(at_ns(0), at_ns(0) + 1ms + kAhead, at_ns(0) + 2ms);
  estimate.add(at_ns(0) + 60s, at_ns(0) + 60s + 2ms + kAhead,
               at_ns(0) + 60s + 3ms);  // 1.5 ms, not 1 + 6 of drift
  EXPECT_EQ(estimate.at(at_ns(0) + 60s + 3ms).uncertainty, 1500us);
}

TEST(ClockOffset, KnowsThisMachinesClock) {
  EXPECT_NE(monotonic_clock_id(), 0u);
  EXPECT_EQ(monotonic_clock_id(), monotonic_clock_id());
}

}  // namespace
}  // namespace copresence::wire
