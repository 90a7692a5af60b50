#include "capture_server/sensor/session_clock.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/recording_scene.h"

namespace copresence::sensor {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Instant kStart{std::chrono::hours(3)};
constexpr std::int64_t kSecond = 1'000'000;
// One session: a camera recorded from 100 to 120 s after 1970, and others.
constexpr SessionSpan kLeft{100 * kSecond, 120 * kSecond}, kRight{102 * kSecond, 121 * kSecond},
    kOther{500 * kSecond, 520 * kSecond};

class SessionClockTest : public testing::Test {
 protected:
  std::optional<SessionClock> join(const SessionSpan& own, Instant begin) const {
    return SessionClock::join(folder_.file(""), own, begin);
  }
  const test::TemporaryFolder folder_;
};

TEST_F(SessionClockTest, ShowsOneInstantOfTheSessionWheneverReplaysAreStarted) {
  const auto left = join(kLeft, kStart);
  const auto right = join(kRight, kStart + milliseconds(3400));
  ASSERT_TRUE(left);
  ASSERT_TRUE(right);
  EXPECT_FALSE(left->is_joined());
  EXPECT_TRUE(right->is_joined());
  for (const std::int64_t at : {102 * kSecond, 110 * kSecond, 119 * kSecond}) {
    EXPECT_EQ(left->timeline().due(at, 0), right->timeline().due(at, 0));
    EXPECT_EQ(left->timeline().due(at, 4), right->timeline().due(at, 4)) << "also in later rounds";
  }
  EXPECT_EQ(left->timeline().due(kLeft.from_us, 0), kStart);
  EXPECT_EQ(right->timeline().due(kRight.from_us, 0), kStart + seconds(2));
  EXPECT_FALSE(right->timeline().contains(kRight.to_us - 1))
      << "the first replay's length is that of a round";
}

TEST_F(SessionClockTest, ALateReplayJoinsTheRoundThatIsShown) {
  const auto left = join(kLeft, kStart);
  const SessionTimeline& timeline = left->timeline();
  EXPECT_EQ(timeline.round_at(kLeft, kStart), 0);
  EXPECT_EQ(timeline.round_at(kLeft, kStart + seconds(19)), 0);
  EXPECT_EQ(timeline.round_at(kLeft, kStart + seconds(20)), 1);
  EXPECT_EQ(timeline.round_at(kLeft, kStart + seconds(61)), 3);
  const SessionSpan middle{105 * kSecond, 110 * kSecond};
  EXPECT_EQ(timeline.round_at(middle, kStart + seconds(9)), 0);
  EXPECT_EQ(timeline.round_at(middle, kStart + seconds(11)), 1) << "its part of round 0 is over";
}

TEST_F(SessionClockTest, AnotherSessionKeepsItsOwnTime) {
  const auto left = join(kLeft, kStart);
  EXPECT_FALSE(join(kOther, kStart));
}

TEST_F(SessionClockTest, ASessionEndsWithItsLastReplay) {
  auto left = join(kLeft, kStart);
  auto right = join(kRight, kStart + seconds(1));
  left.reset();
  EXPECT_EQ(join(kLeft, kStart + seconds(9))->timeline().begin(), kStart) << "one is still playing";
  right.reset();
  EXPECT_EQ(join(kOther, kStart + seconds(50))->timeline().begin(), kStart + seconds(50));
}

TEST_F(SessionClockTest, WhatItsFileSaysIsHostile) {
  const auto left = join(kLeft, kStart);
  std::ofstream(folder_.file("copresence-replay"), std::ios::binary) << std::string(24, '\xff');
  EXPECT_FALSE(join(kRight, kStart));
  std::ofstream(folder_.file("copresence-replay"), std::ios::binary) << "short";
  EXPECT_FALSE(join(kRight, kStart));
  EXPECT_FALSE(SessionClock::join("/nonexistent", kLeft, kStart));
  EXPECT_FALSE(SessionClock::join("", kLeft, kStart));
}

}  // namespace
}  // namespace copresence::sensor
