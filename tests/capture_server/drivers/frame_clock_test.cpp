#include "capture_server/drivers/simulated/frame_clock.h"

#include <gtest/gtest.h>

namespace copresence::drivers {
namespace {

constexpr std::int64_t kToday = 1'700'000'000'000'000;  // microseconds

TEST(FrameClock, GivesEveryoneTheSameFrameAtTheSameTime) {
  FrameClock one, other;
  EXPECT_EQ(one.next(kToday), other.next(kToday));
  EXPECT_EQ(one.next(kToday + 33'400), other.next(kToday + 40'000));
}

TEST(FrameClock, TakesEachFrameOnceAndLater) {
  FrameClock clock;
  std::int64_t last = clock.next(kToday);
  for (int i = 1; i < 100; ++i) {
    const std::int64_t now = FrameClock::instant_us(last) - 20;  // woken a little early
    const std::int64_t frame = clock.next(now);
    EXPECT_EQ(frame, last + 1);
    EXPECT_EQ(clock.index(), i + 1);
    EXPECT_GT(FrameClock::instant_us(frame), now);
    last = frame;
  }
}

TEST(FrameClock, LeavesOutFramesWhoseTimeHasPassedAndCountsThem) {
  FrameClock clock;
  const std::int64_t first = clock.next(kToday);
  EXPECT_EQ(clock.next(kToday + 1'000'000), first + 30);
  EXPECT_EQ(clock.index(), 31);
}

TEST(FrameClock, FollowsAClockThatWasSetBack) {
  FrameClock clock;
  const std::int64_t first = clock.next(kToday);
  EXPECT_EQ(clock.next(kToday - 3'600'000'000), first - 3600 * 30);
  EXPECT_EQ(clock.index(), 2);
  EXPECT_EQ(clock.next(kToday - 3'600'000'000 - 100'000), first - 3600 * 30 + 1);  // a nudge is no reason
}

}  // namespace
}  // namespace copresence::drivers
