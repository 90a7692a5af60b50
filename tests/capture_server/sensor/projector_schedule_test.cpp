#include "capture_server/sensor/projector_schedule.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using Time = ProjectorSchedule::Time;

constexpr Time kSomeDay = std::chrono::hours(24 * 20'000) + milliseconds(123);

TEST(ProjectorSchedule, LetsNoTwoShineAtOnceAndGivesEachItsShare) {
  for (int count : {2, 3, 5}) {
    constexpr milliseconds kTurn(200);
    int shining[5] = {};
    for (Time now = kSomeDay; now < kSomeDay + kTurn * count; now += milliseconds(1)) {
      int at_once = 0;
      for (int i = 0; i < count; ++i) {
        const bool shines = ProjectorSchedule({i, count, kTurn}).is_on(now);
        shining[i] += shines;
        at_once += shines;
      }
      EXPECT_LE(at_once, 1);
    }
    for (int i = 0; i < count; ++i) EXPECT_NEAR(shining[i], 195, 1) << i << " of " << count;
  }
}

TEST(ProjectorSchedule, TellsWhenItChanges) {
  const ProjectorSchedule second({1, 2, milliseconds(200)});
  Time now = kSomeDay;
  for (int changes = 0; changes < 6;) {
    const bool before = second.is_on(now);
    const Time until = second.until_change(now);
    ASSERT_GT(until, Time(0));
    ASSERT_LE(until, milliseconds(200));
    EXPECT_EQ(second.is_on(now + until - Time(1)), before);
    now += until;
    changes += second.is_on(now) != before;
  }
}

TEST(ProjectorSchedule, StaysDarkAMomentBeforeTheNextOnesTurn) {
  const ProjectorSchedule first({0, 2, milliseconds(200)});
  EXPECT_TRUE(first.is_on(milliseconds(0)));
  EXPECT_TRUE(first.is_on(milliseconds(194)));
  EXPECT_FALSE(first.is_on(milliseconds(196)));
  EXPECT_FALSE(first.is_on(milliseconds(300)));
  EXPECT_TRUE(first.is_on(milliseconds(400)));
}

TEST(ProjectorSchedule, RefusesTurnsThatLookLikeAStalledCamera) {
  EXPECT_TRUE((ProjectorSlot{0, 2, milliseconds(500)}.is_sensible()));
  EXPECT_FALSE((ProjectorSlot{2, 2, milliseconds(500)}.is_sensible()));
  EXPECT_FALSE((ProjectorSlot{-1, 2, milliseconds(500)}.is_sensible()));
  EXPECT_FALSE((ProjectorSlot{0, 2, milliseconds(50)}.is_sensible()));
  EXPECT_FALSE((ProjectorSlot{0, 8, milliseconds(500)}.is_sensible()));
}

}  // namespace
}  // namespace copresence::sensor
