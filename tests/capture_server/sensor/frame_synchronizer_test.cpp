#include "capture_server/sensor/frame_synchronizer.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

// Pictures are numbers here; the period is 33 ms.
using Pairing = FrameSynchronizer<int>;

Pairing at_30_fps() {
  return Pairing(16'666, 100'000);
}

TEST(FrameSynchronizer, LetsAPairOnTimeGoAtOnce) {
  Pairing pairing = at_30_fps();
  pairing.add_depth(1'000'000, 1);
  pairing.add_color(1'007'000, 10);
  const auto pair = pairing.take(true);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->depth, 1);
  EXPECT_EQ(pair->color, 10);
  EXPECT_TRUE(pair->same_instant);
  EXPECT_EQ(pair->timestamp_us, 1'000'000);
}

TEST(FrameSynchronizer, TakesColorThatCameBeforeItsDepth) {
  Pairing pairing = at_30_fps();
  pairing.add_color(1'000'000, 10);
  pairing.add_depth(1'011'680, 1);
  const auto pair = pairing.take(true);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->color, 10);
  EXPECT_TRUE(pair->same_instant);
}

TEST(FrameSynchronizer, TellsThePicturesOwnTimesAndWhichColorComesAgain) {
  Pairing pairing = at_30_fps();
  pairing.add_color(1'007'000, 10);
  pairing.add_depth(1'000'000, 1);
  pairing.add_depth(1'033'333, 2);
  const auto first = pairing.take(false), second = pairing.take(false);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(Pairing::times_of(*first).depth.count(), 1'000'000);
  EXPECT_EQ(Pairing::times_of(*first).color.count(), 1'007'000);
  EXPECT_FALSE(Pairing::times_of(*first).color_is_repeated);
  EXPECT_EQ(Pairing::times_of(*second).color.count(), 1'007'000);
  EXPECT_TRUE(Pairing::times_of(*second).color_is_repeated);
}

TEST(FrameSynchronizer, WaitsForColorOnlyWhileAllowed) {
  Pairing pairing = at_30_fps();
  pairing.add_depth(1'000'000, 1);
  EXPECT_FALSE(pairing.take(true));
  const auto pair = pairing.take(false);
  ASSERT_TRUE(pair);
  EXPECT_FALSE(pair->color);
  EXPECT_FALSE(pair->same_instant);
}

TEST(FrameSynchronizer, StopsWaitingWhenTheColorStreamHasPassedBy) {
  Pairing pairing = at_30_fps();
  pairing.add_color(967'000, 9);
  pairing.add_depth(1'000'000, 1);
  EXPECT_FALSE(pairing.take(true));
  pairing.add_color(1'033'000, 11);
  const auto pair = pairing.take(true);
  ASSERT_TRUE(pair);
  EXPECT_FALSE(pair->same_instant);
  EXPECT_TRUE(pair->color) << "a neighbour is shown in its place";
}

TEST(FrameSynchronizer, ShowsTheLastColorAgainForATenthOfASecond) {
  Pairing pairing = at_30_fps();
  pairing.add_depth(1'000'000, 1);
  pairing.add_color(1'000'000, 10);
  ASSERT_TRUE(pairing.take(true));
  for (int i = 1; i <= 4; ++i) {
    pairing.add_depth(1'000'000 + 33'000 * i, 1 + i);
    const auto pair = pairing.take(false);
    ASSERT_TRUE(pair);
    EXPECT_FALSE(pair->same_instant);
    EXPECT_EQ(pair->color.has_value(), i <= 3) << i;
  }
}

TEST(FrameSynchronizer, ChoosesTheNearestOfSeveral) {
  Pairing pairing = at_30_fps();
  pairing.add_color(990'000, 9);
  pairing.add_color(1'002'000, 10);
  pairing.add_color(1'014'000, 11);
  pairing.add_depth(1'000'000, 1);
  EXPECT_EQ(pairing.take(true)->color, 10);
}

TEST(FrameSynchronizer, CountsColorThatNoDepthTook) {
  Pairing pairing = at_30_fps();
  for (int i = 0; i < 6; ++i) pairing.add_color(1'000'000 + 33'333 * i, i);
  pairing.add_depth(1'000'000 + 33'333 * 5, 1);
  EXPECT_EQ(pairing.take(true)->color, 5);
  EXPECT_EQ(pairing.unused_color(), 5u);
}

TEST(FrameSynchronizer, KeepsBoundsWhereDepthNeverComes) {
  Pairing pairing = at_30_fps();
  for (int i = 0; i < 1000; ++i) pairing.add_color(33'333 * i, i);
  EXPECT_GE(pairing.unused_color(), 990u);
}

}  // namespace
}  // namespace copresence::sensor
