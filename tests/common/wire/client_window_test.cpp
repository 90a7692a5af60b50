#include "common/wire/client_window.h"

#include <gtest/gtest.h>

namespace copresence::wire {
namespace {

constexpr std::size_t kSmall = 1000;

/// A window whose client joined with frame 1 and has `last` frames in flight.
ClientWindow with_frames_in_flight(std::uint64_t last) {
  ClientWindow window;
  for (std::uint64_t sequence = 1; sequence <= last; ++sequence) window.sent(sequence, kSmall);
  return window;
}

TEST(ClientWindow, BeginsWithAKeyframe) {
  ClientWindow window;
  EXPECT_FALSE(window.may_have(false));
  EXPECT_TRUE(window.may_have(true));
}

TEST(ClientWindow, TakesSoManyFramesAndNoMore) {
  const ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  EXPECT_FALSE(window.has_room());
  EXPECT_FALSE(window.may_have(true));
}

TEST(ClientWindow, TakesSoManyBytesAndNoMore) {
  ClientWindow window;
  window.sent(1, ClientWindow::kBytes - 1);
  EXPECT_TRUE(window.has_room());
  window.sent(2, kSmall);
  EXPECT_FALSE(window.has_room());
  ASSERT_TRUE(window.acknowledge(1));
  EXPECT_TRUE(window.has_room());
  EXPECT_EQ(window.bytes_in_flight(), kSmall);
}

TEST(ClientWindow, GoesOnWithoutAKeyframeWhenNothingWasSkipped) {
  ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  ASSERT_TRUE(window.acknowledge(1));
  EXPECT_TRUE(window.may_have(false));
}

TEST(ClientWindow, WaitsForAKeyframeOnceItSkipped) {
  ClientWindow window = with_frames_in_flight(ClientWindow::kFrames);
  window.skip(1);
  ASSERT_TRUE(window.acknowledge(ClientWindow::kFrames - 1));
  EXPECT_FALSE(window.has_room()) << "a frame is still in flight";
  ASSERT_TRUE(window.acknowledge(ClientWindow::kFrames));
  EXPECT_TRUE(window.has_room());
  EXPECT_FALSE(window.may_have(false));
  EXPECT_TRUE(window.may_have(true));
  window.sent(20, kSmall);
  EXPECT_TRUE(window.may_have(false));
  EXPECT_EQ(window.skipped(), 1u);
}

TEST(ClientWindow, AcknowledgesEverythingUpToAFrame) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_TRUE(window.acknowledge(3));
  EXPECT_EQ(window.frames_in_flight(), 2u);
  EXPECT_EQ(window.bytes_in_flight(), 2 * kSmall);
}

TEST(ClientWindow, BelievesNoAcknowledgementOfAFrameThatIsNotInFlight) {
  ClientWindow window = with_frames_in_flight(5);
  EXPECT_FALSE(window.acknowledge(6));
  EXPECT_TRUE(window.acknowledge(2));
  EXPECT_FALSE(window.acknowledge(2)) << "twice";
  EXPECT_FALSE(window.acknowledge(0));
}

}  // namespace
}  // namespace copresence::wire
