#include "capture_server/sensor/playback_schedule.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Instant kStart{std::chrono::hours(1)};  // a whole step

TEST(PlaybackSchedule, BeginsAtTheNextStepWheneverItIsAskedSoThatReplaysAreInStep) {
  for (int late_us : {1, 16'000, 33'333, 199'999, 200'000}) {
    PlaybackSchedule schedule;
    EXPECT_EQ(schedule.due(7'000'000, kStart + microseconds(late_us)), kStart + milliseconds(200)) << late_us;
    EXPECT_EQ(schedule.due(7'033'333, kStart + milliseconds(210)), kStart + microseconds(233'333)) << late_us;
  }
}

TEST(PlaybackSchedule, KeepsTheRecordingsDistances) {
  PlaybackSchedule schedule;
  EXPECT_EQ(schedule.due(5'000'000, kStart), kStart);
  EXPECT_EQ(schedule.due(5'033'333, kStart + milliseconds(2)), kStart + microseconds(33'333));
  EXPECT_EQ(schedule.due(5'066'000, kStart + milliseconds(36)), kStart + microseconds(66'000));
}

TEST(PlaybackSchedule, BeginsAtTheInstantThatWasAskedFor) {
  PlaybackSchedule schedule(kStart + milliseconds(700));
  EXPECT_EQ(schedule.due(5'000'000, kStart), kStart + milliseconds(700));
  EXPECT_EQ(schedule.due(5'033'333, kStart + milliseconds(701)), kStart + microseconds(733'333));
}

TEST(PlaybackSchedule, BeginsAtTheNextStepWhereTheInstantHasPassed) {
  PlaybackSchedule schedule(kStart - std::chrono::hours(1));
  EXPECT_EQ(schedule.due(5'000'000, kStart - milliseconds(90)), kStart);
  EXPECT_EQ(schedule.due(5'033'333, kStart), kStart + microseconds(33'333));
}

TEST(PlaybackSchedule, DoesNotDriftWhenEveryFrameIsALittleLate) {
  PlaybackSchedule schedule;
  Instant now = kStart;
  for (int i = 0; i < 30'000; ++i) {
    const Instant due = schedule.due(i * 33'333, now);
    EXPECT_EQ(due, kStart + microseconds(i * 33'333));
    now = due + milliseconds(5);
  }
}

TEST(PlaybackSchedule, MovesTheRestAfterALongDelayInsteadOfABurst) {
  PlaybackSchedule schedule;
  schedule.due(0, kStart);
  const Instant late = kStart + std::chrono::seconds(5);
  EXPECT_EQ(schedule.due(33'333, late), late);
  EXPECT_EQ(schedule.due(66'666, late), late + microseconds(33'333));
}

TEST(PlaybackSchedule, ShortensLongPausesAndIgnoresStepsBack) {
  PlaybackSchedule schedule;
  schedule.due(0, kStart);
  EXPECT_EQ(schedule.due(3'600'000'000, kStart), kStart + std::chrono::seconds(1));
  EXPECT_EQ(schedule.due(33'333, kStart), kStart + std::chrono::seconds(1));
  EXPECT_EQ(schedule.due(66'666, kStart), kStart + std::chrono::seconds(1) + microseconds(33'333));
}

}  // namespace
}  // namespace copresence::sensor
