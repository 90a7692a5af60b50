// Kinects as the server has them: through OpenNI2 and our driver, over the fake libfreenect.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "capture_server/diagnosis/device_listing.h"
#include "capture_server/drivers/kinect_v1/freenect_thread.h"
#include "capture_server/sensor/device_source.h"
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
    EXPECT_EQ(frame->metadata.sequence, i);
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
  const auto source = sensor::open_reconnecting_device("");
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
    EXPECT_EQ(frame->metadata.sequence, i);
    const auto ago = std::chrono::duration_cast<sensor::ProjectorSchedule::Time>(steady_clock::now() -
                                                                                 frame->metadata.captured_at);
    const auto wall = std::chrono::duration_cast<sensor::ProjectorSchedule::Time>(
        std::chrono::system_clock::now().time_since_epoch());
    EXPECT_TRUE(schedule.is_on(wall - ago));
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

TEST_F(KinectCamera, ThatIsSlowToOpenIsWaitedFor) {
  plug_in("A1", "slow_open=1.5");
  const auto source = sensor::open_device("freenect://A1");
  ASSERT_TRUE(source) << source.error().what;
  EXPECT_TRUE((*source)->next({}));
}

TEST_F(KinectCamera, ThatNeverAnswersIsRefusedAndItsThreadEndsWhenItDoes) {
  plug_in("A1", "blocked");
  const auto opened = drivers::FreenectThread::open(
      "A1", [] { ADD_FAILURE() << "it was never open"; }, milliseconds(300));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(opened.error().what, "the Kinect does not answer within 0.3 s: unplug it and plug it in again");
  plug_in("A1");
  EXPECT_TRUE(drivers::FreenectThread::open("A1", [] {}));
}

// The USB bus of a machine as /sys has it, for a Kinect of the fake library.
class KinectListing : public KinectCamera {
 protected:
  void show_on_bus(const std::string& name, const std::string& product, int address,
                   const std::string& serial) const {
    const auto device = bus_ / ("sys/" + name);
    std::filesystem::create_directories(device);
    for (const auto& [file, text] : {std::pair<std::string, std::string>("idVendor", "045e"),
                                     {"idProduct", product},
                                     {"busnum", "1"},
                                     {"devnum", std::to_string(address)},
                                     {"speed", "12"},
                                     {"serial", serial}})
      std::ofstream(device / file) << text << "\n";
    std::filesystem::create_directories(bus_ / "dev/001");
    std::ofstream(bus_ / ("dev/001/0" + std::to_string(address)));
  }
  std::vector<diagnosis::DeviceListing> kinects() const {
    auto listing = diagnosis::list_devices({bus_ / "sys", bus_ / "dev", bus_ / "proc"});
    EXPECT_TRUE(listing);
    if (!listing) return {};
    std::erase_if(*listing, [](const auto& entry) { return entry.driver != "kinect_v1"; });
    return *listing;
  }

  testing::TemporaryFolder bus_;
};

TEST_F(KinectListing, ShowsAModel1473OnceWithWhatTheBusKnows) {
  plug_in("B2", "1473");  // its serial number is its audio device's
  show_on_bus("1-4.1", "02ad", 11, "AUDIOB2");
  show_on_bus("1-4.2", "02ae", 12, std::string(16, '0'));
  const auto listed = kinects();
  ASSERT_EQ(listed.size(), 1u);
  EXPECT_EQ(listed[0].source, "openni:freenect://AUDIOB2");
  EXPECT_TRUE(listed[0].ready);
  EXPECT_THAT(listed[0].problems, ::testing::ElementsAre(::testing::HasSubstr("12 Mbit/s")));
  EXPECT_TRUE(sensor::open_device("freenect://AUDIOB2"));
}

TEST_F(KinectListing, ShowsTwoOfModel1473AndOneFor1414OnceEach) {
  plug_in("B2", "1473");
  plug_in("C3", "1473 windows");
  plug_in("A1");
  show_on_bus("1-4.1", "02ad", 11, "AUDIOB2");
  show_on_bus("1-4.2", "02ae", 12, std::string(16, '0'));
  show_on_bus("1-5.1", "02be", 21, "AUDIOC3");
  show_on_bus("1-5.2", "02bf", 22, std::string(16, '0'));
  show_on_bus("1-6.2", "02ae", 32, "A1");
  const auto listed = kinects();
  ASSERT_EQ(listed.size(), 3u);
  for (const auto& entry : listed) EXPECT_TRUE(entry.ready) << entry.source;
}

}  // namespace
}  // namespace copresence
