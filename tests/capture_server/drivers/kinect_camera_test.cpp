// Kinects as the server has them: through OpenNI2 and our driver, over the fake libfreenect.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "capture_server/sensor/frame_source.h"
#include "tests/capture_server/drivers/fake_kinects.h"
#include "tests/support/fake_freenect/fake_scene.h"

namespace copresence {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
namespace fake = fake_freenect;

class KinectCamera : public testing::FakeKinects {
 protected:
  // The error that ends a camera's frames, at most `frames` of them later.
  static ErrorCode end_of(sensor::FrameSource& source, int frames = 60) {
    for (int i = 0; i < frames; ++i) {
      if (const auto frame = source.next({}); !frame) return frame.error().code;
    }
    return ErrorCode::kInvalid;
  }
};

// How many of the frame's pixels are what the fake scene has there, for the best frame number.
double agreement(const RgbdFrame& frame, bool registered) {
  double best = 0;
  for (std::uint64_t number = 0; number < 160; ++number) {
    int same = 0, all = 0;
    for (int y = 0; y < fake::kHeight; y += 16) {
      for (int x = 0; x < fake::kWidth; x += 16, ++all)
        same += frame.depth.row(y)[static_cast<std::size_t>(x)] == fake::depth_at(x, y, number, registered);
    }
    best = std::max(best, static_cast<double>(same) / all);
  }
  return best;
}

TEST_F(KinectCamera, GivesRegisteredDepthAndColour) {
  plug_in("A00366802032047A");
  const auto source = sensor::open_device("freenect://A00366802032047A");
  ASSERT_TRUE(source) << source.error().what;
  const sensor::SensorDescription& description = (*source)->description();
  EXPECT_EQ(description.depth.width, 640);
  EXPECT_EQ(description.unit, DepthUnit::kMillimetre);
  EXPECT_TRUE(description.has_color);
  EXPECT_TRUE(description.registered);
  EXPECT_NEAR(description.depth.fx, 525, 0.5);  // seen through the colour camera
  EXPECT_EQ(description.levels, fake::levels());
  for (std::uint64_t i = 1; i <= 30; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->stamp.sequence, i);
    ASSERT_TRUE(frame->color);
    EXPECT_EQ(agreement(*frame, true), 1.0);
    const Rgb8 pixel = frame->color->row(100)[40];
    EXPECT_EQ(pixel.r, fake::color_at(40, 100, 0).r);
    EXPECT_EQ(pixel.g, fake::color_at(40, 100, 0).g);
  }
  EXPECT_EQ((*source)->counters().damaged, 0u);
}

TEST_F(KinectCamera, IsOpenedByItsSerialNumberWhateverElseIsPluggedIn) {
  for (const char* serial : {"B2", "A1", "C3"}) plug_in(serial);
  plug_in("B2", "stall");
  const auto one = sensor::open_device("freenect://C3"), other = sensor::open_device("freenect://A1");
  ASSERT_TRUE(one && other);
  EXPECT_TRUE((*one)->next({}));
  EXPECT_TRUE((*other)->next({}));
  unplug("A1");
  EXPECT_EQ(end_of(**other), ErrorCode::kUnavailable);
  EXPECT_TRUE((*one)->next({}));  // and does not mind the others
  EXPECT_EQ(sensor::open_device("freenect://D4").error().code, ErrorCode::kNotFound);
}

TEST_F(KinectCamera, EndsWithASentenceWhenItsTransfersFail) {
  plug_in("A1");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source);
  ASSERT_TRUE((*source)->next({}));
  plug_in("A1", "transfer_error");
  EXPECT_EQ(end_of(**source), ErrorCode::kUnavailable);
}

TEST_F(KinectCamera, EndsWithASentenceWhenItFallsSilent) {
  plug_in("A1");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source);
  ASSERT_TRUE((*source)->next({}));
  plug_in("A1", "stall");
  EXPECT_EQ(end_of(**source), ErrorCode::kTimeout);
}

TEST_F(KinectCamera, MayBeginSlowly) {
  plug_in("A1", "slow_start");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source);
  EXPECT_TRUE((*source)->next({}));
}

TEST_F(KinectCamera, ShowsLostPacketsAsHoles) {
  plug_in("A1", "short_frame");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source);
  const auto frame = (*source)->next({});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->state.row(10)[100], DepthState::kMeasured);
  EXPECT_EQ(frame->state.row(470)[100], DepthState::kHole);
}

TEST_F(KinectCamera, SaysWhyItDoesNotOpen) {
  plug_in("A1", "busy");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().what, ::testing::HasSubstr("claim"));
}

TEST_F(KinectCamera, WorksWithoutAMotor) {
  plug_in("A1", "no_motor");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source) << source.error().what;
  EXPECT_TRUE((*source)->next({}));
}

TEST_F(KinectCamera, IsUnpluggedAndPluggedInTenTimes) {
  for (int round = 0; round < 10; ++round) {
    plug_in("A1");
    const auto source = sensor::open_device("freenect://A1");
    ASSERT_TRUE(source) << source.error().what;
    ASSERT_TRUE((*source)->next({}));
    unplug("A1");
    ASSERT_EQ(end_of(**source), ErrorCode::kUnavailable);
  }
}

TEST_F(KinectCamera, IsWaitedForWhenItWasTheFirstAndNoOtherIsTaken) {
  plug_in("A1");
  const auto source = sensor::open_lasting_device("");
  ASSERT_TRUE(source) << source.error().what;
  EXPECT_EQ((*source)->description().uri, "freenect://A1");
  plug_in("B2");
  unplug("A1");
  EXPECT_EQ(end_of(**source), ErrorCode::kUnavailable);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE((*source)->next({}));
  plug_in("A1");
  bool back = false;
  for (int i = 0; i < 8 && !back; ++i) back = (*source)->next({}).has_value();
  EXPECT_TRUE(back);
}

TEST_F(KinectCamera, SendsDepthOfItsOwnTurnsOnly) {
  plug_in("A1");
  sensor::CameraControls controls;
  controls.projector = sensor::ProjectorSlot{1, 3, milliseconds(200)};
  const auto source = sensor::open_device("freenect://A1", controls);
  ASSERT_TRUE(source) << source.error().what;
  const sensor::ProjectorSchedule schedule(*controls.projector);
  const auto begin = steady_clock::now();
  for (std::uint64_t i = 1; i <= 12; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->stamp.sequence, i);
    const auto ago = std::chrono::duration_cast<sensor::ProjectorSchedule::Time>(steady_clock::now() -
                                                                                 frame->stamp.captured_at);
    const auto wall = std::chrono::duration_cast<sensor::ProjectorSchedule::Time>(
        std::chrono::system_clock::now().time_since_epoch());
    EXPECT_TRUE(schedule.shines(wall - ago));
  }
  EXPECT_GT(steady_clock::now() - begin, milliseconds(1000));  // three turns of four frames
  EXPECT_EQ((*source)->counters().damaged, 0u);
}

TEST_F(KinectCamera, IsNotMissedWhileItWaitsForItsTurn) {
  plug_in("A1");
  sensor::CameraControls controls;
  controls.projector = sensor::ProjectorSlot{0, 3, milliseconds(1000)};
  const auto source = sensor::open_device("freenect://A1", controls);
  ASSERT_TRUE(source) << source.error().what;
  for (int i = 0; i < 45; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
  }
  unplug("A1");
  EXPECT_EQ(end_of(**source), ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace copresence
