#include "common/wire/flow_control/path_estimate.h"

#include <gtest/gtest.h>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTolerance = 66ms;
const Instant kNow = Instant{} + 100s;

/// Two frames that were in flight together on a path of 50 ms and 1 MB a second.
PathEstimate known_path() {
  PathEstimate path(kTolerance);
  path.acknowledged({kNow, 100'000, true}, kNow + 150ms);
  path.acknowledged({kNow + 33ms, 50'000, false}, kNow + 200ms);
  return path;
}

TEST(PathEstimate, KnowsNothingBeforeTheFirstAcknowledgement) {
  const PathEstimate path(kTolerance);
  EXPECT_FALSE(path.base_delay());
  EXPECT_FALSE(path.delivery_rate());
  EXPECT_EQ(path.transmission_time(1000), Duration::zero());
  EXPECT_FALSE(path.is_stale(kNow));
}

TEST(PathEstimate, TellsTheLengthOfAPathFromTheTransmissionOfAKeyframe) {
  const PathEstimate path = known_path();
  ASSERT_TRUE(path.delivery_rate());
  EXPECT_NEAR(*path.delivery_rate(), 1e6, 1);
  EXPECT_EQ(*path.base_delay(), Duration(50ms));
  EXPECT_EQ(path.transmission_time(50'000), Duration(50ms));
}

TEST(PathEstimate, TakesNoBunchOfAcknowledgementsForAWidePath) {
  PathEstimate path(kTolerance);
  path.acknowledged({kNow, 30'000, true}, kNow + 100ms);
  for (int i = 1; i < 20; ++i) path.acknowledged({kNow + i * 33ms, 30'000, false}, kNow + 700ms);
  EXPECT_LE(*path.delivery_rate(), 30'000 / 0.033 + 1);
}

TEST(PathEstimate, TakesNoStandingQueueForALongerPath) {
  PathEstimate path = known_path();
  for (int i = 0; i < 600; ++i) {
    const Instant sent = kNow + 1s + i * 50ms;
    path.acknowledged({sent, 50'000, false}, sent + 300ms);
  }
  EXPECT_EQ(*path.base_delay(), Duration(50ms));
  EXPECT_TRUE(path.is_stale(kNow + 31s)) << "the sender must let the path run empty";
  path.acknowledged({kNow + 32s, 50'000, true}, kNow + 32s + 100ms);
  EXPECT_FALSE(path.is_stale(kNow + 33s));
  EXPECT_LE(*path.base_delay(), 100ms);
}

TEST(PathEstimate, CorrectsAKeyframeWhoseTransmissionWasOverstated) {
  PathEstimate path(kTolerance);
  path.acknowledged({kNow, 120'000, true}, kNow + 200ms);
  // The path is wide: only sending limits the rate, to 30 kB in 33 ms.
  path.acknowledged({kNow + 33ms, 30'000, false}, kNow + 33ms + 200ms);
  EXPECT_GE(*path.base_delay() + path.transmission_time(30'000), 199ms);
}

TEST(PathEstimate, TakesNoQueueBehindAKeyframeForTheBase) {
  PathEstimate path(kTolerance);  // 2 ms and 500 kB a second
  path.acknowledged({kNow, 120'000, true}, kNow + 242ms);
  path.acknowledged({kNow + 33ms, 30'000, false}, kNow + 302ms);
  EXPECT_LE(*path.base_delay(), 3ms);
}

TEST(PathEstimate, BelievesAFrameThatHadALongerPathToItself) {
  PathEstimate path = known_path();
  path.acknowledged({kNow + 1s, 10'000, true}, kNow + 1s + 400ms);
  path.acknowledged({kNow + 1s + 33ms, 10'000, false}, kNow + 1s + 433ms);
  EXPECT_GE(*path.base_delay(), 350ms);
}

TEST(PathEstimate, FollowsAShorterPathAtOnce) {
  PathEstimate path = known_path();
  path.acknowledged({kNow + 1s, 50'000, false}, kNow + 1s + 70ms);
  EXPECT_LE(*path.base_delay(), 20ms);
}

TEST(PathEstimate, ForgetsARateThatABusyPathNoLongerReaches) {
  PathEstimate path = known_path();
  Instant acknowledged = kNow + 200ms;
  for (int i = 0; i < 30; ++i) {  // 250 kB a second, with a queue
    acknowledged += 200ms;
    path.acknowledged({acknowledged - 400ms, 50'000, false}, acknowledged);
  }
  EXPECT_NEAR(*path.delivery_rate(), 250e3, 1e3);
}

TEST(PathEstimate, KeepsTheRateOfAPathThatIsNotUsedUp) {
  PathEstimate path = known_path();
  for (int i = 0; i < 300; ++i) {
    const Instant sent = kNow + 1s + i * 33ms;
    path.acknowledged({sent, 1000, false}, sent + 51ms);
  }
  EXPECT_NEAR(*path.delivery_rate(), 1e6, 1);
}

}  // namespace
}  // namespace copresence::wire
