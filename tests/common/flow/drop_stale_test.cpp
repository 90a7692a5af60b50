#include "common/flow/drop_stale.h"

#include <gtest/gtest.h>

namespace copresence::flow {
namespace {

using std::chrono::milliseconds;

constexpr Instant kFree{std::chrono::hours(1)};
constexpr milliseconds kPeriod{30};

TEST(Freshness, AFrameThatHasWaitedLongerThanTheNextOneTakesIsOvertaken) {
  EXPECT_TRUE(should_drop_stale(kFree - milliseconds(16), kFree, kPeriod));
  EXPECT_TRUE(should_drop_stale(kFree - milliseconds(300), kFree, kPeriod));
}

TEST(Freshness, AFrameThatTheNextOneIsFurtherAwayThanIsNot) {
  EXPECT_FALSE(should_drop_stale(kFree, kFree, kPeriod));
  EXPECT_FALSE(should_drop_stale(kFree - milliseconds(15), kFree, kPeriod));
}

TEST(Freshness, NoFrameIsOvertakenThatFoundTheWorkerFreeHoweverLateItIsLookedAt) {
  EXPECT_FALSE(should_drop_stale(kFree + milliseconds(1), kFree, kPeriod));
}

}  // namespace
}  // namespace copresence::flow
