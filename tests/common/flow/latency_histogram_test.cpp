#include "common/flow/latency_histogram.h"

#include <gtest/gtest.h>

namespace copresence::flow {
namespace {

using std::chrono::milliseconds;

TEST(LatencyHistogram, IsZeroWhileEmpty) {
  EXPECT_EQ(LatencyHistogram().percentile_ms(50), 0.0);
}

TEST(LatencyHistogram, FindsPercentilesToOnePercent) {
  LatencyHistogram timing;
  for (int ms = 1; ms <= 1000; ++ms) timing.add(milliseconds(ms));
  EXPECT_NEAR(timing.percentile_ms(50), 500, 10);
  EXPECT_NEAR(timing.percentile_ms(95), 950, 19);
  EXPECT_NEAR(timing.percentile_ms(99), 990, 20);
}

TEST(LatencyHistogram, HoldsDurationsOutsideItsRangeAtItsEnds) {
  LatencyHistogram timing;
  timing.add(Duration(-5));
  EXPECT_LT(timing.percentile_ms(50), 0.01);
  timing = {};
  timing.add(std::chrono::hours(24));
  EXPECT_GT(timing.percentile_ms(50), 1e5);
}

TEST(LatencyHistogram, ReturnsWhatWasAddedSinceACopy) {
  LatencyHistogram timing;
  for (int i = 0; i < 100; ++i) timing.add(milliseconds(10));
  const LatencyHistogram earlier = timing;
  for (int i = 0; i < 5; ++i) timing.add(milliseconds(80));
  EXPECT_EQ(timing.since(earlier).count(), 5u);
  EXPECT_NEAR(timing.since(earlier).percentile_ms(50), 80, 1);
  EXPECT_EQ(timing.since(timing).percentile_ms(50), 0);
}

}  // namespace
}  // namespace copresence::flow
