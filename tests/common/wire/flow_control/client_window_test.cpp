#include "common/wire/flow_control/client_window.h"

#include <gtest/gtest.h>

namespace copresence::wire {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kSmall = 1000;
constexpr Duration kPeriod = 33ms;
const Instant kNow = Instant{} + 100s;

/// A window whose client joined with frame 1 and has `last` frames in flight; the path is unknown.
ClientWindow with_frames_in_flight(std::uint64_t last) {
  ClientWindow window(kPeriod);
  for (std::uint64_t sequence = 1; sequence <= last; ++sequence) window.sent(sequence, kSmall, kNow);
  return window;
}

bool wants(const ClientWindow& window, Instant now = kNow) {
  return now < window.wants_until();
}

TEST(ClientWindow, BeginsWithAKeyframe) {
  const ClientWindow window(kPeriod);
  EXPECT_TRUE(window.awaits_keyframe());
  EXPECT_FALSE(window.fell_behind());
  EXPECT_FALSE(wants(window));
  EXPECT_FALSE(window.can_accept(false, kNow));
  EXPECT_TRUE(window.can_accept(true, kNow));
}

TEST(ClientWindow, TakesFewFramesWhileThePathIsUnknown) {
  EXPECT_TRUE(wants(with_frames_in_flight(1)));
  EXPECT_FALSE(wants(with_frames_in_flight(2)));
  EXPECT_TRUE(with_frames_in_flight(2).can_accept(false, kNow)) << "of those that are encoded for others";
  EXPECT_TRUE(with_frames_in_flight(ClientWindow::kFramesOnUnknownPath - 1).can_accept(false, kNow));
  EXPECT_FALSE(with_frames_in_flight(ClientWindow::kFramesOnUnknownPath).can_accept(true, kNow));
}

TEST(ClientWindow, TakesSoManyBytesAndNoMore) {
  ClientWindow window(kPeriod);
  window.sent(1, ClientWindow::kBytes - 1, kNow);
  EXPECT_TRUE(window.can_accept(false, kNow));
  window.sent(2, kSmall, kNow);
  EXPECT_FALSE(window.can_accept(false, kNow));
  ASSERT_TRUE(window.acknowledge(1, kNow + 1ms));
  EXPECT_TRUE(window.can_accept(false, kNow + 1ms));
  EXPECT_EQ(window.bytes_in_flight(), kSmall);
}

TEST(ClientWindow, GoesOnWithoutAKeyframeWhenNothingWasSkipped) {
  ClientWindow window = with_frames_in_flight(2);
  ASSERT_TRUE(window.acknowledge(1, kNow + 10ms));
  EXPECT_TRUE(wants(window, kNow + 10ms));
  EXPECT_TRUE(window.can_accept(false, kNow + 10ms));
}

TEST(ClientWindow, WaitsForAKeyframeOnceItSkipped) {
  ClientWindow window = with_frames_in_flight(6);
  window.skip(1);
  EXPECT_TRUE(window.fell_behind());
  ASSERT_TRUE(window.acknowledge(5, kNow));
  EXPECT_FALSE(window.awaits_keyframe()) << "a frame is still in flight";
  EXPECT_FALSE(window.can_accept(true, kNow));
  ASSERT_TRUE(window.acknowledge(6, kNow));
  EXPECT_TRUE(window.awaits_keyframe());
  EXPECT_FALSE(window.can_accept(false, kNow));
  EXPECT_TRUE(window.can_accept(true, kNow));
  window.sent(20, kSmall, kNow);
  EXPECT_FALSE(window.fell_behind());
  EXPECT_TRUE(window.can_accept(false, kNow));
  EXPECT_EQ(window.skipped(), 1u);
}

TEST(ClientWindow, AcknowledgesEverythingUpToAFrame) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_TRUE(window.acknowledge(3, kNow));
  EXPECT_EQ(window.frames_in_flight(), 2u);
  EXPECT_EQ(window.bytes_in_flight(), 2 * kSmall);
  EXPECT_EQ(window.acknowledged(), 3u);
}

TEST(ClientWindow, BelievesNoAcknowledgementOfAFrameThatIsNotInFlight) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_FALSE(window.acknowledge(6, kNow));
  EXPECT_TRUE(window.acknowledge(2, kNow));
  EXPECT_FALSE(window.acknowledge(2, kNow)) << "twice";
  EXPECT_FALSE(window.acknowledge(0, kNow));
}

TEST(ClientWindow, WantsNothingWhileTheOldestFrameIsOverdue) {
  ClientWindow window = with_frames_in_flight(2);
  ASSERT_TRUE(window.acknowledge(1, kNow + 10ms));
  ASSERT_TRUE(window.acknowledge(2, kNow + 11ms));
  window.sent(3, kSmall, kNow + 1s);
  EXPECT_TRUE(wants(window, kNow + 1s + 3 * kPeriod));
  EXPECT_FALSE(wants(window, kNow + 1s + 4 * kPeriod));
  EXPECT_TRUE(window.can_accept(false, kNow + 1s + 5 * kPeriod)) << "rather than a keyframe later";
  EXPECT_FALSE(window.can_accept(false, kNow + 1s + 6 * kPeriod));
  ASSERT_TRUE(window.acknowledge(3, kNow + 2s));
  EXPECT_TRUE(wants(window, kNow + 2s));
}

TEST(ClientWindow, WaitsLongerOnAPathWithJitter) {
  ClientWindow window(kPeriod);
  Instant now = kNow;
  for (std::uint64_t sequence = 1; sequence <= 60; ++sequence, now += kPeriod) {
    window.sent(sequence, kSmall, now);
    ASSERT_TRUE(window.acknowledge(sequence, now + (sequence % 2 ? 5ms : 60ms)));
  }
  window.sent(61, kSmall, now);
  EXPECT_TRUE(wants(window, now + 4 * kPeriod));
  EXPECT_FALSE(wants(window, now + 6 * kPeriod));
}

}  // namespace
}  // namespace copresence::wire
