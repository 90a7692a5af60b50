#include "capture_server/sensor/playback_schedule.h"

#include <gtest/gtest.h>

namespace copresence::sensor {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Instant kStart{std::chrono::hours(1)};  // a whole step
constexpr microseconds kPeriod{33'333};

TEST(PlaybackSchedule, BeginsAtTheNextStepWheneverItIsAskedSoThatReplaysAreInStep) {
  for (int late_us : {1, 16'000, 33'333, 199'999, 200'000}) {
    PlaybackSchedule schedule(kPeriod);
    EXPECT_EQ(schedule.due(7'000'000, kStart + microseconds(late_us)), kStart + milliseconds(200)) << late_us;
    EXPECT_EQ(schedule.due(7'033'333, kStart + milliseconds(210)), kStart + microseconds(233'333)) << late_us;
  }
}

TEST(PlaybackSchedule, KeepsTheRecordingsDistances) {
  PlaybackSchedule schedule(kPeriod);
  EXPECT_EQ(schedule.due(5'000'000, kStart), kStart);
  EXPECT_EQ(schedule.due(5'033'333, kStart + milliseconds(2)), kStart + microseconds(33'333));
  EXPECT_EQ(schedule.due(5'066'000, kStart + milliseconds(36)), kStart + microseconds(66'000));
}

TEST(PlaybackSchedule, BeginsAtTheInstantThatWasAskedFor) {
  PlaybackSchedule schedule(kPeriod, kStart + milliseconds(700));
  EXPECT_EQ(schedule.due(5'000'000, kStart), kStart + milliseconds(700));
  EXPECT_EQ(schedule.due(5'033'333, kStart + milliseconds(701)), kStart + microseconds(733'333));
}

TEST(PlaybackSchedule, BeginsAtTheNextStepWhereTheInstantHasPassed) {
  PlaybackSchedule schedule(kPeriod, kStart - std::chrono::hours(1));
  EXPECT_EQ(schedule.due(5'000'000, kStart - milliseconds(90)), kStart);
  EXPECT_EQ(schedule.due(5'033'333, kStart), kStart + microseconds(33'333));
}

TEST(PlaybackSchedule, DoesNotDriftWhenEveryFrameIsALittleLate) {
  PlaybackSchedule schedule(kPeriod);
  Instant now = kStart;
  for (int i = 0; i < 30'000; ++i) {
    const Instant due = schedule.due(i * 33'333, now);
    EXPECT_EQ(due, kStart + microseconds(i * 33'333));
    now = due + milliseconds(5);
  }
}

TEST(PlaybackSchedule, MovesTheRestAfterALongDelayInsteadOfABurst) {
  PlaybackSchedule schedule(kPeriod);
  schedule.due(0, kStart);
  const Instant late = kStart + std::chrono::seconds(5);
  EXPECT_EQ(schedule.due(33'333, late), late);
  EXPECT_EQ(schedule.due(66'666, late), late + microseconds(33'333));
}

TEST(PlaybackSchedule, ShortensLongPauses) {
  PlaybackSchedule schedule(kPeriod);
  schedule.due(0, kStart);
  EXPECT_EQ(schedule.due(3'600'000'000, kStart), kStart + std::chrono::seconds(1));
  EXPECT_EQ(schedule.due(3'600'033'333, kStart), kStart + std::chrono::seconds(1) + kPeriod);
}

TEST(PlaybackSchedule, KeepsTheNominalRateWhereTimesStandStillOrGoBack) {
  PlaybackSchedule still(kPeriod), back(kPeriod);
  for (int i = 0; i < 210; ++i) {
    EXPECT_EQ(still.due(7, kStart), kStart + i * kPeriod) << i;
    EXPECT_EQ(back.due(i % 2 ? 1'000'000'000 : 0, kStart) >= kStart + i * kPeriod, true) << i;
  }
}

TEST(PlaybackSchedule, KeepsARecordingsLengthWhereFramesShareTimes) {
  // Two frames at each time, two periods apart.
  PlaybackSchedule schedule(kPeriod);
  for (int i = 0; i < 60; ++i) {
    const std::int64_t time_us = i / 2 * 2 * 33'333;
    EXPECT_EQ(schedule.due(time_us, kStart), kStart + i * kPeriod) << i;
  }
}

TEST(PlaybackSchedule, GoesOnAtTheRecordingsRateAfterTimesStoodStill) {
  PlaybackSchedule schedule(kPeriod);
  for (int i = 0; i < 100; ++i) schedule.due(0, kStart);
  Instant before = schedule.due(1, kStart);
  for (int i = 1; i < 20; ++i) {
    const Instant due = schedule.due(1 + i * 33'333, kStart);
    EXPECT_EQ(due - before, kPeriod) << i;
    before = due;
  }
}

}  // namespace
}  // namespace copresence::sensor
