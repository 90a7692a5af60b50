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

}  // namespace
}  // namespace copresence::flow
