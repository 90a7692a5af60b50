#include "render_client/stream/availability.h"

#include <gtest/gtest.h>

#include <vector>

namespace copresence::stream {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

Instant at(int ms) {
  return Instant(milliseconds(1'000'000 + ms));
}

const Error kNothingListens{ErrorCode::kNotFound, "a:1: nothing listens there"};
const Error kHungUp{ErrorCode::kUnavailable, "a:1: the server hung up"};
const Error kGarbage{ErrorCode::kCorrupt, "a:1: this is no capture_server"};
const Error kUnknownCodec{ErrorCode::kUnsupported, "a:1: codec \"h265\" is unknown"};
const Error kOtherVersion{ErrorCode::kRefused, "a:1: install the same release"};
const Error kEnded{ErrorCode::kEndOfStream, "a:1: the recording is over"};

TEST(Availability, ACameraIsAwaitedUntilAFrameDecodes) {
  AvailabilityTracker camera;
  EXPECT_EQ(camera.availability(), Availability::kAwaited);
  for (int i = 0; i < 100; ++i) camera.failed(kNothingListens, at(500 * i));
  EXPECT_EQ(camera.availability(), Availability::kAwaited) << "a server that is not there may come";
  camera.connected();
  EXPECT_EQ(camera.availability(), Availability::kAwaited);
  camera.decoded(at(60'000));
  EXPECT_EQ(camera.availability(), Availability::kShown);
}

TEST(Availability, AnotherVersionIsFinalAndAnUnknownCodecIsTriedAgain) {
  AvailabilityTracker camera;
  EXPECT_TRUE(camera.failed(kUnknownCodec, at(0)));
  EXPECT_EQ(camera.availability(), Availability::kRefused);
  EXPECT_EQ(camera.reason(), kUnknownCodec.what);
  camera.connected();
  camera.decoded(at(500));
  EXPECT_EQ(camera.availability(), Availability::kShown) << "the server was started anew with another codec";
  EXPECT_FALSE(camera.failed(kOtherVersion, at(1000)));
  EXPECT_EQ(camera.availability(), Availability::kRefused);
}

TEST(Availability, AServerThatAnswersWithoutFramesIsLeftOutAfterAWhile) {
  for (const Error& why : {kHungUp, kGarbage}) {
    AvailabilityTracker camera;
    camera.failed(why, at(0));
    camera.failed(why, at(2900));
    EXPECT_EQ(camera.availability(), Availability::kAwaited);
    camera.failed(why, at(3000));
    EXPECT_EQ(camera.availability(), Availability::kLeftOut);
    EXPECT_EQ(camera.reason(), why.what);
    camera.connected();
    EXPECT_EQ(camera.availability(), Availability::kLeftOut) << "a welcome alone shows nothing";
    camera.decoded(at(3100));
    EXPECT_EQ(camera.availability(), Availability::kShown);
  }
}

TEST(Availability, FramesThatNeverDecodeLeaveTheCameraOut) {
  AvailabilityTracker camera;
  camera.connected();
  camera.decoded(at(0));
  for (int ms = 100; ms < 3100; ms += 100) {
    camera.undecodable("damaged", at(ms));
    EXPECT_FALSE(is_left_out(camera.availability())) << ms;
  }
  camera.undecodable("damaged", at(3100));
  EXPECT_EQ(camera.availability(), Availability::kLeftOut);
  EXPECT_EQ(camera.reason(), "damaged");
}

TEST(Availability, AServerThatGoesAwayIsAwaitedAgain) {
  AvailabilityTracker camera;
  camera.failed(kHungUp, at(0));
  camera.failed(kHungUp, at(3000));
  ASSERT_EQ(camera.availability(), Availability::kLeftOut);
  camera.failed(kNothingListens, at(3500));
  EXPECT_EQ(camera.availability(), Availability::kAwaited);
  camera.failed(kHungUp, at(4000));
  EXPECT_EQ(camera.availability(), Availability::kAwaited) << "the time counts from here";
  camera.failed(kEnded, at(9000));
  EXPECT_EQ(camera.availability(), Availability::kAwaited);
}

TEST(Availability, PausesGrowToHalfASecondAndNoFurther) {
  AvailabilityTracker camera;
  std::vector<int> pauses;
  for (int i = 0; i < 6; ++i)
    pauses.push_back(static_cast<int>(*camera.failed(kNothingListens, at(i)) / milliseconds(1)));
  EXPECT_EQ(pauses, (std::vector{50, 100, 200, 400, 500, 500}));
}

TEST(Availability, WelcomesAndSingleFramesDoNotShortenThePause) {
  AvailabilityTracker camera;
  int connections = 0;
  for (Instant now = at(0); now < at(10'000); ++connections) {
    camera.connected();
    camera.decoded(now);
    now += milliseconds(1) + *camera.failed(kHungUp, now);
  }
  EXPECT_LE(connections, 24) << "two a second, once the pause has grown";
}

TEST(Availability, TwoSecondsOfFramesMakeTheNextPauseShort) {
  AvailabilityTracker camera;
  for (int i = 0; i < 9; ++i) camera.failed(kNothingListens, at(i));
  camera.connected();
  camera.decoded(at(1000));
  camera.decoded(at(2999));
  EXPECT_EQ(*camera.failed(kHungUp, at(3000)), milliseconds(500));
  camera.connected();
  camera.decoded(at(4000));
  camera.decoded(at(6000));
  EXPECT_EQ(*camera.failed(kHungUp, at(6000)), milliseconds(50));
}

}  // namespace
}  // namespace copresence::stream
