#include "render_client/stream/frame_times.h"

#include <gtest/gtest.h>

#include <limits>

namespace copresence::stream {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr Instant kReceived{hours(20)};

TEST(FrameTimes, AreMappedToThisClock) {
  const wire::ClockOffset ahead{seconds(1000), milliseconds(1)};
  const Instant sent = kReceived - milliseconds(8) + ahead.offset;
  const FrameTimes times = frame_times(sent - milliseconds(20), sent, kReceived, ahead);
  ASSERT_TRUE(times.are_believed());
  EXPECT_EQ(times.captured_at, kReceived - milliseconds(28));
  EXPECT_EQ(*times.wire, milliseconds(8));
}

TEST(FrameTimes, MayBeWrongByWhatTheClockIsNotSureOf) {
  const wire::ClockOffset unsure{Duration::zero(), milliseconds(50)};
  EXPECT_TRUE(frame_times(kReceived, kReceived + milliseconds(50), kReceived, unsure).are_believed());
  EXPECT_FALSE(frame_times(kReceived, kReceived + milliseconds(60), kReceived, unsure).are_believed());
}

TEST(FrameTimes, AreNotBelievedWhereTheyContradictEachOther) {
  const auto is_believed = [](Duration captured_before, Duration sent_before) {
    const FrameTimes times = frame_times(kReceived - captured_before, kReceived - sent_before, kReceived, {});
    if (!times.are_believed()) {
      EXPECT_EQ(times.captured_at, kReceived);
    }
    return times.are_believed();
  };
  EXPECT_TRUE(is_believed(seconds(9), milliseconds(5)));
  EXPECT_FALSE(is_believed(seconds(11), milliseconds(5))) << "older than any connection allows";
  EXPECT_FALSE(is_believed(hours(1), hours(1)));
  EXPECT_FALSE(is_believed(milliseconds(5), milliseconds(20))) << "captured after it was sent";
  EXPECT_FALSE(is_believed(-hours(1), milliseconds(5)));
  EXPECT_FALSE(is_believed(-hours(1), -hours(1))) << "sent after it came";
}

TEST(FrameTimes, TakeAnyNumber) {
  const Instant extremes[] = {Instant::min(), Instant::min() + nanoseconds(1), Instant(nanoseconds(-1)),
                              Instant(),      Instant::max() - nanoseconds(1), Instant::max()};
  const Duration far = Duration::max() / 4;
  for (const Instant captured : extremes) {
    for (const Instant sent : extremes) {
      for (const Duration offset : {Duration::zero(), far, -far}) {
        const FrameTimes times = frame_times(captured, sent, kReceived, {offset, milliseconds(1)});
        EXPECT_LE(kReceived - times.captured_at, kOldestBelieved + milliseconds(1));
        EXPECT_GE(kReceived - times.captured_at, -milliseconds(20));
      }
    }
  }
}

}  // namespace
}  // namespace copresence::stream
