#include "render_client/session/replay_control.h"

#include <gtest/gtest.h>

namespace copresence::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A recording from 1 s to 21 s with a frame each 100 ms.
class ReplayControlTest : public ::testing::Test {
 protected:
  Time at(milliseconds now) { return control_.position(Instant(std::chrono::hours(1)) + now); }

  ReplayControl control_{seconds(1), seconds(21), [](Time time) -> std::optional<Time> {
                           if (time >= seconds(21)) return std::nullopt;
                           return Time((time.count() / 1000 + 1) * 1000);
                         }};
};

TEST_F(ReplayControlTest, RunsInRealTimeAndStopsAtTheEnd) {
  EXPECT_EQ(at(milliseconds(0)), seconds(1));
  EXPECT_EQ(at(milliseconds(500)), milliseconds(1500));
  EXPECT_EQ(control_.text(), "0:00 of 0:20");
  EXPECT_EQ(at(seconds(100)), seconds(21));
  EXPECT_EQ(control_.text(), "0:20 of 0:20, end");
}

TEST_F(ReplayControlTest, StandsStillWhilePausedAndGoesOnFromThere) {
  at(milliseconds(0));
  at(seconds(1));
  EXPECT_FALSE(control_.apply(ReplayCommand::kPause));
  EXPECT_EQ(at(seconds(10)), seconds(2));
  EXPECT_EQ(control_.text(), "0:01 of 0:20, paused");
  control_.apply(ReplayCommand::kPause);
  EXPECT_EQ(at(seconds(11)), seconds(3));
}

TEST_F(ReplayControlTest, AStepGoesToTheNextFrameAndPauses) {
  at(milliseconds(0));
  at(milliseconds(150));
  control_.apply(ReplayCommand::kStep);
  EXPECT_EQ(at(milliseconds(200)), milliseconds(1200));
  control_.apply(ReplayCommand::kStep);
  EXPECT_EQ(at(milliseconds(900)), milliseconds(1300));
}

TEST_F(ReplayControlTest, SpeedsDoubleAndHalveWithinLimits) {
  at(milliseconds(0));
  control_.apply(ReplayCommand::kFaster);
  EXPECT_EQ(at(seconds(1)), seconds(3));
  EXPECT_EQ(control_.text(), "0:02 of 0:20, 2x");
  for (int i = 0; i < 20; ++i) control_.apply(ReplayCommand::kSlower);
  EXPECT_EQ(at(seconds(9)), seconds(4));
  for (int i = 0; i < 20; ++i) control_.apply(ReplayCommand::kFaster);
  EXPECT_EQ(at(seconds(10)), seconds(12));
}

TEST_F(ReplayControlTest, JumpsStayWithinTheRecording) {
  at(milliseconds(0));
  at(seconds(2));
  EXPECT_TRUE(control_.apply(ReplayCommand::kForward));
  EXPECT_EQ(at(seconds(2)), seconds(8));
  EXPECT_TRUE(control_.apply(ReplayCommand::kBack));
  EXPECT_TRUE(control_.apply(ReplayCommand::kBack));
  EXPECT_EQ(at(seconds(2)), seconds(1));
  for (int i = 0; i < 9; ++i) control_.apply(ReplayCommand::kForward);
  EXPECT_EQ(at(seconds(2)), seconds(21));
  EXPECT_TRUE(control_.apply(ReplayCommand::kRestart));
  EXPECT_EQ(at(seconds(2)), seconds(1));
}

}  // namespace
}  // namespace copresence::session
