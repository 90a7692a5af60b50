#include "render_client/pacing/arrival_clock.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>

namespace copresence::pacing {
namespace {

Instant at_ms(double ms) {
  return Instant(std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms)));
}
double ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}
double ms(Instant instant) {
  return ms(instant.time_since_epoch());
}

TEST(ArrivalClock, RunsFromTheSecondFrameUntilFramesStayAway) {
  ArrivalClock clock;
  EXPECT_FALSE(clock.is_running(at_ms(0)));
  clock.arrived(at_ms(1000));
  EXPECT_FALSE(clock.is_running(at_ms(1001)));
  clock.arrived(at_ms(1033));
  EXPECT_TRUE(clock.is_running(at_ms(1100)));
  EXPECT_FALSE(clock.is_running(at_ms(1300)));
}

TEST(ArrivalClock, FindsPeriodAndPhaseThroughJitter) {
  ArrivalClock clock;
  std::mt19937 random(1);
  std::normal_distribution<double> jitter(0, 3);
  for (int i = 0; i < 300; ++i) clock.arrived(at_ms(1000 + i * 33.367 + jitter(random)));
  EXPECT_NEAR(ms(clock.period()), 33.367, 0.3);
  EXPECT_NEAR(ms(clock.expected()), 1000 + 300 * 33.367, 2);
  EXPECT_GT(ms(clock.patience()), 6);
}

TEST(ArrivalClock, IsNotPatientWithACameraThatIsPunctual) {
  ArrivalClock clock;
  for (int i = 0; i < 100; ++i) clock.arrived(at_ms(i * 33.3));
  EXPECT_NEAR(ms(clock.patience()), 2, 0.1);
}

TEST(ArrivalClock, BridgesALostFrame) {
  ArrivalClock clock;
  for (int i = 0; i < 100; ++i) {
    if (i % 7 != 3) clock.arrived(at_ms(i * 33.3));
  }
  EXPECT_NEAR(ms(clock.period()), 33.3, 0.1);
  EXPECT_NEAR(ms(clock.expected()), 100 * 33.3, 0.5);
}

TEST(ArrivalClock, FollowsACameraToAnotherRateAndAnotherPhase) {
  ArrivalClock clock;
  for (int i = 0; i < 50; ++i) clock.arrived(at_ms(i * 33.3));
  for (int i = 0; i < 50; ++i) clock.arrived(at_ms(1700 + i * 66.7));
  EXPECT_NEAR(ms(clock.period()), 66.7, 0.5);
  for (int i = 0; i < 50; ++i) clock.arrived(at_ms(5050 + i * 33.3));
  EXPECT_NEAR(ms(clock.period()), 33.3, 0.5);
  EXPECT_NEAR(ms(clock.expected()), 5050 + 50 * 33.3, 0.5);
}

}  // namespace
}  // namespace copresence::pacing
