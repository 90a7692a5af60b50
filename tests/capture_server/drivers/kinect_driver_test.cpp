// The Kinect driver as OpenNI2 has it, over the fake libfreenect: what no frame source shows.

#include <OpenNI.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <thread>

#include "capture_server/drivers/contract/device_properties.h"
#include "capture_server/drivers/contract/driver_choice.h"
#include "tests/capture_server/drivers/fake_kinects.h"
#include "tests/support/fake_freenect/fake_scene.h"
#include "tests/support/open_ni.h"

namespace copresence {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
namespace fake = fake_freenect;

class KinectDriver : public testing::FakeKinects {
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
  void start(openni::VideoStream& stream, openni::SensorType type) {
    ASSERT_EQ(stream.create(device_, type), openni::STATUS_OK);
    ASSERT_EQ(stream.start(), openni::STATUS_OK);
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
  start(depth, openni::SENSOR_DEPTH);
  start(color, openni::SENSOR_COLOR);
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
  start(depth, openni::SENSOR_DEPTH);
  start(color, openni::SENSOR_COLOR);
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
  start(depth, openni::SENSOR_DEPTH);
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
