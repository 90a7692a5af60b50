#include "render_client/pacing/stale_cameras.h"

#include <gtest/gtest.h>

#include <chrono>

namespace copresence::pacing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Change = StaleCameras::Change;

constexpr milliseconds kPeriod{33};
const Instant kBegin{seconds(100)};

class Stale : public testing::Test {
 protected:
  StaleCameras cameras{2, seconds(3)};
};

TEST_F(Stale, ACameraFadesAfterASecondAndIsGoneAfterThree) {
  cameras.frame_arrived(0, kPeriod, kBegin);
  EXPECT_EQ(cameras.opacity(0, kBegin + milliseconds(990)), 1);
  EXPECT_LT(cameras.opacity(0, kBegin + milliseconds(1100)), 1);
  EXPECT_NEAR(cameras.opacity(0, kBegin + seconds(2)), 0.5, 1e-3);
  EXPECT_GT(cameras.opacity(0, kBegin + milliseconds(2990)), 0);
  EXPECT_EQ(cameras.opacity(0, kBegin + seconds(3)), 0);
  EXPECT_EQ(cameras.opacity(0, kBegin + seconds(3000)), 0);
}

TEST_F(Stale, TheFadeScalesWithTheWholeTime) {
  StaleCameras patient(1, seconds(30));
  patient.frame_arrived(0, kPeriod, kBegin);
  EXPECT_EQ(patient.opacity(0, kBegin + seconds(10)), 1);
  EXPECT_NEAR(patient.opacity(0, kBegin + seconds(20)), 0.5, 1e-3);
  EXPECT_EQ(patient.opacity(0, kBegin + seconds(30)), 0);
}

TEST_F(Stale, ACameraIsDrawnAtOnceWhenItComesBack) {
  cameras.frame_arrived(0, kPeriod, kBegin);
  cameras.frame_arrived(0, kPeriod, kBegin + seconds(60));
  EXPECT_EQ(cameras.opacity(0, kBegin + seconds(60)), 1);
}

TEST_F(Stale, RareFramesAreNotTakenForAStop) {
  constexpr seconds kRare{4};
  cameras.frame_arrived(0, kRare, kBegin);
  EXPECT_EQ(cameras.opacity(0, kBegin + seconds(8)), 1);
  EXPECT_EQ(cameras.opacity(0, kBegin + seconds(12)), 0);
}

TEST_F(Stale, ACameraThatHasNeverSentAnythingIsNotStale) {
  EXPECT_EQ(cameras.opacity(1, kBegin + seconds(1000)), 1);
  EXPECT_FALSE(cameras.next_view(kBegin));
  EXPECT_TRUE(cameras.changes(kBegin + seconds(1000)).empty());
}

TEST_F(Stale, ViewsAreDrawnUntilTheLastCameraIsGone) {
  cameras.frame_arrived(0, kPeriod, kBegin);
  cameras.frame_arrived(1, kPeriod, kBegin + milliseconds(500));
  // Draws views when they are due, as the client's loop does, and counts them.
  Instant drawn_at = kBegin + milliseconds(500);
  int views = 0;
  float before = 1;
  while (const auto next = cameras.next_view(drawn_at)) {
    ASSERT_GT(*next, drawn_at);
    drawn_at = *next;
    ++views;
    const float opacity = cameras.opacity(1, drawn_at);
    EXPECT_LE(opacity, before);
    before = opacity;
    ASSERT_LT(views, 100);
  }
  EXPECT_EQ(drawn_at, kBegin + milliseconds(3500)) << "the last view shows neither";
  EXPECT_GE(views, 20);
  EXPECT_LE(views, 45);
}

TEST_F(Stale, ChangesAreReportedOnce) {
  cameras.frame_arrived(1, kPeriod, kBegin);
  EXPECT_TRUE(cameras.changes(kBegin + milliseconds(900)).empty());
  auto changes = cameras.changes(kBegin + milliseconds(1100));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].camera, 1U);
  EXPECT_EQ(changes[0].change, Change::kStale);
  EXPECT_TRUE(changes[0].worth_saying);
  EXPECT_TRUE(cameras.changes(kBegin + milliseconds(1200)).empty());
  cameras.frame_arrived(1, kPeriod, kBegin + seconds(2));
  changes = cameras.changes(kBegin + seconds(2));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].change, Change::kBack);
  EXPECT_TRUE(changes[0].worth_saying);
}

TEST_F(Stale, ACameraThatComesAndGoesFillsNoLog) {
  int said = 0, happened = 0;
  // A frame every two seconds, of a camera with a nominal rate of 30 per second.
  for (int i = 0; i < 30; ++i) {
    const Instant at = kBegin + i * seconds(2);
    cameras.frame_arrived(0, kPeriod, at);
    for (const Instant now : {at, at + milliseconds(1500)}) {
      for (const auto& change : cameras.changes(now)) {
        ++happened;
        said += change.worth_saying;
      }
    }
  }
  EXPECT_EQ(happened, 59);
  EXPECT_LE(said, 12) << "stale and back, every ten seconds of a minute";
  EXPECT_GE(said, 10);
}

}  // namespace
}  // namespace copresence::pacing
