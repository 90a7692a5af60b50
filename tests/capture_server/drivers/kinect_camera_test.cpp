// Kinects as the server has them: through OpenNI2 and our driver, over the fake libfreenect.

#include <OpenNI.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/frame_source.h"
#include "tests/support/fake_freenect/fake_scene.h"
#include "tests/support/open_ni.h"
#include "tests/support/process.h"

namespace copresence {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
namespace fake = fake_freenect;

class KinectCamera : public ::testing::Test {
 protected:
  KinectCamera() { ::setenv("COPRESENCE_FAKE_KINECTS", bus().c_str(), 1); }

  std::string bus() const { return (folder_ / "").string(); }
  void plug_in(const std::string& serial, const std::string& faults = "") const {
    std::ofstream(folder_ / serial) << faults;
  }
  void unplug(const std::string& serial) const { std::filesystem::remove(folder_ / serial); }

  // The error that ends a camera's frames, at most `frames` of them later.
  static ErrorCode end_of(sensor::FrameSource& source, int frames = 60) {
    for (int i = 0; i < frames; ++i) {
      if (const auto frame = source.next({}); !frame) return frame.error().code;
    }
    return ErrorCode::kInvalid;
  }

  testing::TemporaryFolder folder_;
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

// OpenNI2 itself, for what no frame source shows.
class KinectDriver : public KinectCamera {
 protected:
  KinectDriver() {
    ::setenv(drivers::kChoiceVariable, "kinect_v1", 1);
    plug_in("A1");
    EXPECT_EQ(testing::start_open_ni(), openni::STATUS_OK);
  }
  ~KinectDriver() override {
    device_.close();
    openni::OpenNI::shutdown();
  }
  void open(const std::string& faults = "") {
    plug_in("A1", faults);
    ASSERT_EQ(device_.open("freenect://A1"), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
  }

  openni::Device device_;
};

TEST_F(KinectDriver, TellsItsSerialNumberBeforeAnyStream) {
  open();
  char serial[64] = {};
  int size = sizeof(serial);
  EXPECT_EQ(device_.getProperty(ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial, &size), openni::STATUS_OK);
  EXPECT_STREQ(serial, "A1");
  EXPECT_EQ(device_.getImageRegistrationMode(), openni::IMAGE_REGISTRATION_OFF);
}

TEST_F(KinectDriver, MeasuresUnregisteredDepthAndSwitchesWhileItRuns) {
  open();
  openni::VideoStream depth;
  ASSERT_EQ(depth.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  EXPECT_NEAR(depth.getHorizontalFieldOfView(), 1.0144686, 1e-4);
  ASSERT_EQ(depth.start(), openni::STATUS_OK);
  const auto pixel = [&](int x, int y) {
    openni::VideoFrameRef frame;
    EXPECT_EQ(depth.readFrame(&frame), openni::STATUS_OK);
    return static_cast<const std::uint16_t*>(frame.getData())[y * 640 + x];
  };
  EXPECT_EQ(pixel(100, 10), fake::depth_at(100, 10, 0, false));
  ASSERT_EQ(device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR), openni::STATUS_OK);
  std::this_thread::sleep_for(milliseconds(150));
  pixel(0, 0);
  EXPECT_EQ(pixel(100, 10), fake::depth_at(100, 10, 0, true));
  EXPECT_NEAR(depth.getHorizontalFieldOfView(), 1.0942, 1e-3);
  depth.stop();
  depth.destroy();
}

TEST_F(KinectDriver, StampsDepthAndColourInMicrosecondsThatDoNotWrap) {
  open();
  openni::VideoStream depth, color;
  ASSERT_EQ(depth.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  ASSERT_EQ(color.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
  ASSERT_EQ(depth.start(), openni::STATUS_OK);
  ASSERT_EQ(color.start(), openni::STATUS_OK);
  openni::VideoStream* streams[] = {&depth, &color};
  std::uint64_t last[2] = {0, 0};
  for (int i = 0; i < 60; ++i) {  // a second: the fake's clock wraps in its middle
    int ready = 0;
    ASSERT_EQ(openni::OpenNI::waitForAnyStream(streams, 2, &ready, 1000), openni::STATUS_OK);
    openni::VideoFrameRef frame;
    ASSERT_EQ(streams[ready]->readFrame(&frame), openni::STATUS_OK);
    if (last[ready]) {
      const double passed = static_cast<double>(frame.getTimestamp() - last[ready]);
      EXPECT_NEAR(std::remainder(passed, 33'333.3), 0, 100);
      EXPECT_LT(passed, 500'000);
    }
    last[ready] = frame.getTimestamp();
  }
  EXPECT_LT(std::abs(static_cast<double>(last[0]) - static_cast<double>(last[1])), 100'000);
  depth.destroy();
  color.destroy();
}

TEST_F(KinectDriver, SendsInfraredInsteadOfColour) {
  open();
  openni::VideoStream infrared, color;
  ASSERT_EQ(infrared.create(device_, openni::SENSOR_IR), openni::STATUS_OK);
  ASSERT_EQ(color.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
  ASSERT_EQ(infrared.start(), openni::STATUS_OK);
  EXPECT_NE(color.start(), openni::STATUS_OK);
  EXPECT_THAT(openni::OpenNI::getExtendedError(), ::testing::HasSubstr("infrared"));
  openni::VideoFrameRef frame;
  ASSERT_EQ(infrared.readFrame(&frame), openni::STATUS_OK);
  EXPECT_EQ(frame.getHeight(), 480);
  EXPECT_EQ(static_cast<const std::uint8_t*>(frame.getData())[20 * 640 + 500], fake::infrared_at(500, 20, 0));
  infrared.destroy();
  color.destroy();
}

TEST_F(KinectDriver, TiltsShinesAndKnowsNoNearMode) {
  open();
  EXPECT_EQ(device_.setProperty(drivers::kTilt, 12.0), openni::STATUS_OK);
  double degrees = 0;
  EXPECT_EQ(device_.getProperty(drivers::kTilt, &degrees), openni::STATUS_OK);
  EXPECT_EQ(degrees, 12.0);
  EXPECT_NE(device_.setProperty(drivers::kTilt, 80.0), openni::STATUS_OK);
  EXPECT_EQ(device_.setProperty(drivers::kLight, static_cast<int>(drivers::Light::kGreen)),
            openni::STATUS_OK);
  EXPECT_NE(device_.setProperty(drivers::kLight, 5), openni::STATUS_OK);
  EXPECT_NE(device_.setProperty(drivers::kNearMode, 1), openni::STATUS_OK);
  EXPECT_THAT(openni::OpenNI::getExtendedError(), ::testing::HasSubstr("Kinect for Windows"));
}

TEST_F(KinectDriver, SendsNoDepthWhileItsProjectorIsDarkAndColourGoesOn) {
  open();
  openni::VideoStream depth, color;
  ASSERT_EQ(depth.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  ASSERT_EQ(color.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
  ASSERT_EQ(depth.start(), openni::STATUS_OK);
  ASSERT_EQ(color.start(), openni::STATUS_OK);
  const auto sends = [](openni::VideoStream& stream) {
    openni::VideoStream* streams[] = {&stream};
    openni::VideoFrameRef old;
    int ready = 0;
    if (openni::OpenNI::waitForAnyStream(streams, 1, &ready, 0) == openni::STATUS_OK) stream.readFrame(&old);
    return openni::OpenNI::waitForAnyStream(streams, 1, &ready, 300) == openni::STATUS_OK;
  };
  EXPECT_TRUE(sends(depth));
  ASSERT_EQ(device_.setProperty(drivers::kProjector, 0), openni::STATUS_OK);
  EXPECT_FALSE(sends(depth));
  EXPECT_TRUE(sends(color));
  int shines = 1;
  EXPECT_EQ(device_.getProperty(drivers::kProjector, &shines), openni::STATUS_OK);
  EXPECT_EQ(shines, 0);
  ASSERT_EQ(device_.setProperty(drivers::kProjector, 1), openni::STATUS_OK);
  EXPECT_TRUE(sends(depth));
  depth.destroy();
  color.destroy();
}

TEST_F(KinectDriver, ForWindowsHasANearMode) {
  open("windows no_motor");
  EXPECT_EQ(device_.setProperty(drivers::kNearMode, 1), openni::STATUS_OK);
  EXPECT_NE(device_.setProperty(drivers::kTilt, 12.0), openni::STATUS_OK);
}

TEST_F(KinectDriver, FixesExposureAndWhiteBalance) {
  open();
  openni::VideoStream color;
  ASSERT_EQ(color.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
  openni::CameraSettings* settings = color.getCameraSettings();
  ASSERT_TRUE(settings);
  EXPECT_TRUE(settings->getAutoExposureEnabled());
  EXPECT_EQ(settings->setAutoExposureEnabled(false), openni::STATUS_OK);
  EXPECT_EQ(settings->setAutoWhiteBalanceEnabled(false), openni::STATUS_OK);
  EXPECT_FALSE(settings->getAutoExposureEnabled());
  EXPECT_FALSE(settings->getAutoWhiteBalanceEnabled());
  color.destroy();
}

class Events final : public openni::OpenNI::DeviceConnectedListener,
                     public openni::OpenNI::DeviceDisconnectedListener {
 public:
  Events() {
    openni::OpenNI::addDeviceConnectedListener(this);
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Events() override {
    openni::OpenNI::removeDeviceConnectedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  void onDeviceConnected(const openni::DeviceInfo*) override { ++came; }
  void onDeviceDisconnected(const openni::DeviceInfo*) override { ++went; }
  static bool within(milliseconds time, const std::function<bool()>& holds) {
    for (const auto end = steady_clock::now() + time; steady_clock::now() < end;) {
      if (holds()) return true;
      std::this_thread::sleep_for(milliseconds(5));
    }
    return false;
  }
  std::atomic<int> came = 0, went = 0;
};

TEST_F(KinectDriver, TellsWhenKinectsComeAndGo) {
  Events events;
  plug_in("B2");
  EXPECT_TRUE(Events::within(seconds(1), [&] { return events.came == 1; }));
  unplug("B2");
  EXPECT_TRUE(Events::within(seconds(1), [&] { return events.went == 1; }));
  plug_in("B2");
  EXPECT_TRUE(Events::within(seconds(1), [&] { return events.came == 2; }));
}

TEST_F(KinectDriver, ComesBackByItselfAfterAFailedTransfer) {
  open();
  openni::VideoStream depth;
  ASSERT_EQ(depth.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  ASSERT_EQ(depth.start(), openni::STATUS_OK);
  Events events;
  plug_in("A1", "transfer_error");
  EXPECT_TRUE(Events::within(seconds(1), [&] { return events.went == 1; }));
  plug_in("A1");
  EXPECT_TRUE(Events::within(seconds(1), [&] { return events.came >= 1; }));
  depth.destroy();
  device_.close();
  open();
}

}  // namespace
}  // namespace copresence
