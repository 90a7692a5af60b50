// The simulated camera as the server has it: through OpenNI2, from the private driver folder.

#include <OpenNI.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "capture_server/drivers/contract/driver_choice.h"
#include "capture_server/sensor/source.h"
#include "common/flow/worker_pool.h"
#include "simulation/sensor/frame_marker.h"
#include "simulation/sensor/kinect_depth.h"
#include "simulation/sensor/simulated_kinect.h"
#include "tests/support/open_ni.h"
#include "tests/support/process.h"

namespace copresence {
namespace {

using std::chrono::milliseconds;

TEST(SimulatedCamera, IsALiveKinectThatKnowsItsPlace) {
  const auto source = sensor::open_source("simulated:room?camera=1", {});
  ASSERT_TRUE(source) << source.error().what;
  const sensor::SensorDescription& description = (*source)->description();
  const CameraModel model = simulation::kinect_model(640, 480);
  EXPECT_DOUBLE_EQ(description.depth.fx, model.fx);
  EXPECT_DOUBLE_EQ(description.depth.cx, model.cx);
  EXPECT_TRUE(description.has_color);
  EXPECT_TRUE(description.registered);
  EXPECT_FALSE(description.is_recording);
  ASSERT_TRUE(description.world_from_camera);
  EXPECT_TRUE(description.world_from_camera->rotation.isApprox(simulation::kinect_poses(2)[1].rotation));
  EXPECT_EQ(description.levels, simulation::kinect_levels(DepthUnit::kMillimetre));
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t i = 1; i <= 15; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->metadata.sequence, i);
    ASSERT_TRUE(frame->color);
    for (const std::uint16_t z : frame->depth.pixels())
      ASSERT_TRUE(z == 0 || std::binary_search(description.levels.begin(), description.levels.end(), z)) << z;
    EXPECT_GT(
        std::count_if(frame->depth.pixels().begin(), frame->depth.pixels().end(), [](auto z) { return z; }),
        640 * 480 / 2);
  }
  EXPECT_GT(std::chrono::steady_clock::now() - begin, milliseconds(400));  // at its own pace
}

TEST(SimulatedCamera, ShowsItsFrameNumberByTheSystemClock) {
  const auto source = sensor::open_source("simulated:empty-room?camera=0&marker=on", {});
  ASSERT_TRUE(source) << source.error().what;
  for (int i = 0; i < 5; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame && frame->color);
    const auto number = simulation::read_marker(*frame->color);
    ASSERT_TRUE(number);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const double due = std::fmod(std::chrono::duration<double>(now).count() * 30, 4294967296.0);
    EXPECT_LT(*number, due + 1);
    EXPECT_GT(*number, due - 10);  // a third of a second, for machines that are far too busy
  }
}

TEST(SimulatedCamera, SaysWhenItIsUnpluggedAndGoesOnWithinASecond) {
  testing::TemporaryFolder folder;
  const auto plug = folder / "plug";
  const std::string uri = "simulated:empty-room?camera=0&control=" + plug.string();
  EXPECT_EQ(sensor::open_source(uri, {}).error().code, ErrorCode::kNotFound);
  std::ofstream(plug).close();
  const auto source = sensor::open_source(uri, {});
  ASSERT_TRUE(source) << source.error().what;
  std::uint64_t last = 0;
  for (int round = 0; round < 3; ++round) {
    const auto first = (*source)->next({});
    ASSERT_TRUE(first) << first.error().what;
    EXPECT_EQ(first->metadata.sequence, ++last);
    std::filesystem::remove(plug);
    auto frame = (*source)->next({});
    for (; frame; frame = (*source)->next({})) last = frame->metadata.sequence;
    EXPECT_EQ(frame.error().code, ErrorCode::kUnavailable);
    std::ofstream(plug).close();
    const auto plugged_in = std::chrono::steady_clock::now();
    while (!(frame = (*source)->next({}))) {
      ASSERT_LT(std::chrono::steady_clock::now() - plugged_in, milliseconds(1000));
    }
    EXPECT_EQ(frame->metadata.sequence, ++last);
  }
}

std::unique_ptr<sensor::FrameSource> lit_in_turns(const std::string& uri,
                                                  std::optional<sensor::ProjectorSlot> slot) {
  sensor::SourceSettings settings;
  settings.controls.projector = slot;
  auto source = sensor::open_source(uri, settings);
  if (!source) throw std::runtime_error(source.error().what);
  return std::move(*source);
}

// What a camera delivers for a while: its share of holes, and its frames a second.
struct Delivered {
  double holes = 0, frames_per_second = 0;
};
Delivered watch(sensor::FrameSource& source, std::chrono::steady_clock::time_point begin) {
  while (std::chrono::steady_clock::now() < begin) (void)source.next({});
  std::ptrdiff_t holes = 0;
  int frames = 0;
  constexpr std::chrono::seconds kWatched(3);
  while (std::chrono::steady_clock::now() < begin + kWatched) {
    const auto frame = source.next({});
    if (!frame) throw std::runtime_error(frame.error().what);
    holes += std::count(frame->depth.pixels().begin(), frame->depth.pixels().end(), 0);
    ++frames;
  }
  return {static_cast<double>(holes) / (640.0 * 480 * std::max(frames, 1)),
          static_cast<double>(frames) / static_cast<double>(kWatched.count())};
}

TEST(SimulatedCamera, LosesNothingToOtherProjectorsWhenTheyTakeTurns) {
  testing::TemporaryFolder folder;
  const std::string air = "&cameras=2&projectors=" + (folder / "air").string();
  const auto uri = [&](int camera) { return "simulated:empty-room?camera=" + std::to_string(camera) + air; };
  const auto in_a_moment = [] { return std::chrono::steady_clock::now() + std::chrono::seconds(2); };
  flow::WorkerPool watchers(2, "watch");  // until the end: see frame_source.h about threads that wait
  const auto both = [&](std::optional<sensor::ProjectorSlot> first,
                        std::optional<sensor::ProjectorSlot> second) {
    // One after the other: OpenNI2 does not open two devices at a time.
    const auto camera_0 = lit_in_turns(uri(0), first), camera_1 = lit_in_turns(uri(1), second);
    const auto begin = in_a_moment();
    std::array<Delivered, 2> delivered;
    watchers.run(2, [&](int i, int) { delivered[i] = watch(i == 0 ? *camera_0 : *camera_1, begin); });
    return delivered;
  };
  const Delivered alone = watch(*lit_in_turns(uri(0), {}), in_a_moment());
  if (alone.frames_per_second < 15)
    GTEST_SKIP()
        << "SKIPPED: a simulated camera makes " << alone.frames_per_second
        << " frames a second here (under a sanitizer, or on a machine too busy): too few for turns of "
           "0.3 s";
  const auto [disturbed, also] = both({}, {});
  constexpr milliseconds kTurn(300);
  const auto [first, second] = both(sensor::ProjectorSlot{0, 2, kTurn}, sensor::ProjectorSlot{1, 2, kTurn});

  EXPECT_GT(disturbed.holes, alone.holes + 0.004);
  EXPECT_LT(first.holes,
            (alone.holes + disturbed.holes) / 2);  // some, where a machine is too busy to switch in time
  EXPECT_LT(second.holes, also.holes);
  for (const Delivered& shared : {first, second}) {
    EXPECT_GT(shared.frames_per_second, 3);
    EXPECT_LT(shared.frames_per_second, 15);
  }
  RecordProperty("alone",
                 std::to_string(alone.holes) + " holes, " + std::to_string(alone.frames_per_second) + "/s");
  RecordProperty("disturbed", std::to_string(disturbed.holes));
  RecordProperty("turns",
                 std::to_string(first.holes) + " holes, " + std::to_string(first.frames_per_second) + "/s");
}

TEST(SimulatedCamera, HasNoDepthInTheDarkAndItsTurnsAreCounted) {
  sensor::SourceSettings settings;
  settings.controls.projector = sensor::ProjectorSlot{0, 2, milliseconds(200)};
  const auto source = sensor::open_source("simulated:empty-room?camera=0", settings);
  ASSERT_TRUE(source) << source.error().what;
  for (std::uint64_t i = 1; i <= 10; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->metadata.sequence, i);
    EXPECT_GT(
        std::count_if(frame->depth.pixels().begin(), frame->depth.pixels().end(), [](auto z) { return z; }),
        640 * 480 / 2);
  }
  EXPECT_GT((*source)->counters().projector_off, 10u);
}

// OpenNI2 itself, for what no frame source shows.
class SimulatedDriver : public ::testing::Test {
 protected:
  SimulatedDriver() {
    ::setenv(drivers::kChoiceVariable, "simulated", 1);
    EXPECT_EQ(testing::start_open_ni(), openni::STATUS_OK);
    EXPECT_EQ(device_.open("simulated:empty-room?camera=0&marker=on"), openni::STATUS_OK)
        << openni::OpenNI::getExtendedError();
    EXPECT_EQ(depth_.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
    EXPECT_EQ(color_.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
    kinect_.precompute();
  }
  ~SimulatedDriver() override {
    depth_.destroy();
    color_.destroy();
    device_.close();
    openni::OpenNI::shutdown();
  }

  // Reads one picture and expects it to be what the simulated Kinect has at that instant. Returns when, in microseconds.
  std::uint64_t expect_truth(openni::VideoStream& stream) {
    openni::VideoStream* streams[] = {&stream};
    int ready = 0;
    openni::VideoFrameRef picture;
    EXPECT_EQ(openni::OpenNI::waitForAnyStream(streams, 1, &ready, 2000), openni::STATUS_OK);
    if (stream.readFrame(&picture) != openni::STATUS_OK) throw std::runtime_error("no picture");
    const std::uint64_t frame = (picture.getTimestamp() * 30 + 500'000) / 1'000'000;
    const auto expect = [&](auto& expected) {
      ASSERT_EQ(static_cast<std::size_t>(picture.getDataSize()), expected.pixels().size_bytes());
      EXPECT_EQ(std::memcmp(picture.getData(), expected.data(), expected.pixels().size_bytes()), 0) << frame;
    };
    if (&stream == &depth_) {
      DepthImage expected(640, 480);
      kinect_.capture_live_depth(frame, expected.pixels());
      expect(expected);
    } else {
      ColorImage expected(640, 480);
      kinect_.capture_live_color(frame, expected.pixels());
      simulation::draw_marker(static_cast<std::uint32_t>(frame), expected.pixels(), 640);
      expect(expected);
    }
    return picture.getTimestamp();
  }

  openni::Device device_;
  openni::VideoStream depth_, color_;
  simulation::SimulatedKinect kinect_ =
      simulation::SimulatedKinect::make(
          std::make_shared<const simulation::LitScene>(simulation::LitScene::of_world("empty-room").value()),
          simulation::kinect_model(640, 480), simulation::kinect_poses(2), 0, DepthUnit::kMillimetre, 1)
          .value();
};

TEST_F(SimulatedDriver, SendsWhatTheKinectHasAtThatInstant) {
  ASSERT_EQ(depth_.start(), openni::STATUS_OK);
  ASSERT_EQ(color_.start(), openni::STATUS_OK);
  for (int i = 0; i < 5; ++i) {
    expect_truth(depth_);
    expect_truth(color_);
  }
}

TEST_F(SimulatedDriver, SendsEitherPictureWhileTheOtherIsNotWanted) {
  std::uint64_t last = 0;
  const auto expect_news = [&](openni::VideoStream& stream) {
    const std::uint64_t now = expect_truth(stream);
    EXPECT_GE(now, last);
    last = now;
  };
  for (int round = 0; round < 3; ++round) {
    ASSERT_EQ(depth_.start(), openni::STATUS_OK);
    expect_news(depth_);
    ASSERT_EQ(color_.start(), openni::STATUS_OK);
    expect_news(color_);
    depth_.stop();
    expect_news(color_);
    expect_news(color_);
    color_.stop();
  }
}

TEST(SimulatedCamera, IsNoCameraWhereItCannotBe) {
  EXPECT_EQ(sensor::open_source("simulated:moon", {}).error().code, ErrorCode::kInvalid);
  EXPECT_EQ(sensor::open_source("simulated:room?camera=9", {}).error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace copresence
