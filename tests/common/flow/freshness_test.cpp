#include "common/flow/freshness.h"

#include <gtest/gtest.h>

namespace copresence::flow {
namespace {

using std::chrono::milliseconds;

constexpr Instant kFree{std::chrono::hours(1)};
constexpr milliseconds kPeriod{30};

TEST(Freshness, AFrameThatHasWaitedLongerThanTheNextOneTakesIsOvertaken) {
  EXPECT_TRUE(is_overtaken(kFree - milliseconds(16), kFree, kPeriod));
  EXPECT_TRUE(is_overtaken(kFree - milliseconds(300), kFree, kPeriod));
}

TEST(Freshness, AFrameThatTheNextOneIsFurtherAwayThanIsNot) {
  EXPECT_FALSE(is_overtaken(kFree, kFree, kPeriod));
  EXPECT_FALSE(is_overtaken(kFree - milliseconds(15), kFree, kPeriod));
}

TEST(Freshness, NoFrameIsOvertakenThatFoundTheWorkerFreeHoweverLateItIsLookedAt) {
  EXPECT_FALSE(is_overtaken(kFree + milliseconds(1), kFree, kPeriod));
}

}  // namespace
}  // namespace copresence::flow
