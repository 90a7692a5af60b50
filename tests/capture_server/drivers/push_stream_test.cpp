#include "capture_server/drivers/contract/push_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

namespace copresence::drivers {
namespace {

using namespace std::chrono_literals;

constexpr OniVideoMode kTiny{ONI_PIXEL_FORMAT_DEPTH_1_MM, 4, 3, 30};
constexpr OniVideoMode kTinier{ONI_PIXEL_FORMAT_DEPTH_1_MM, 2, 1, 30};

// OpenNI2's side: memory for one picture, counted, and what it does when it is handed one.
class OpenNiSide {
 public:
  explicit OpenNiSide(PushStream& stream) {
    OniStreamServices& services = services_;  // whose functions oni::driver::StreamServices hides
    services.streamServices = this;
    services.acquireFrame = [](void* self) { return static_cast<OpenNiSide*>(self)->acquire(); };
    services.releaseFrame = [](void* self, OniFrame*) { --static_cast<OpenNiSide*>(self)->out; };
    stream.setServices(&services_);
    stream.setNewFrameCallback(
        [](oni::driver::StreamBase*, OniFrame* frame, void* self) {
          auto& side = *static_cast<OpenNiSide*>(self);
          ++side.handed;
          if (side.when_handed) side.when_handed(*frame);
        },
        this);
  }

  std::atomic<int> out = 0, handed = 0;
  bool has_memory = true;
  std::function<void(const OniFrame&)> when_handed;

 private:
  OniFrame* acquire() {
    if (!has_memory) return nullptr;
    ++out;
    frame_.data = memory_;
    return &frame_;
  }

  oni::driver::StreamServices services_;
  OniFrame frame_{};
  alignas(16) std::byte memory_[64];
};

class Owner final : public StreamOwner {
 public:
  OniStatus begin(PushStream&) override {
    ++begun;
    return answer;
  }
  void end(PushStream&) override { ++ended; }

  OniStatus answer = ONI_STATUS_OK;
  int begun = 0, ended = 0;
};

class PushedStream : public testing::Test {
 protected:
  Owner owner;
  PushStream stream{owner, ONI_SENSOR_DEPTH, {kTiny, kTinier}, 10000};
  OpenNiSide open_ni{stream};
};

TEST_F(PushedStream, HandsOverAPictureOfItsModeWithItsTimeAndNumber) {
  ASSERT_EQ(stream.start(), ONI_STATUS_OK);
  auto picture = stream.next_picture();
  ASSERT_TRUE(picture);
  const auto pixels = picture->pixels<std::uint16_t>();
  ASSERT_EQ(pixels.size(), 12u);
  std::fill(pixels.begin(), pixels.end(), std::uint16_t{1234});
  open_ni.when_handed = [](const OniFrame& frame) {
    EXPECT_EQ(frame.width, 4);
    EXPECT_EQ(frame.height, 3);
    EXPECT_EQ(frame.stride, 8);
    EXPECT_EQ(frame.timestamp, 77u);
    EXPECT_EQ(frame.frameIndex, 5);
    EXPECT_EQ(static_cast<const std::uint16_t*>(frame.data)[11], 1234);
  };
  picture->send(77, 5);
  EXPECT_EQ(open_ni.handed, 1);
  EXPECT_EQ(open_ni.out, 0);
}

TEST_F(PushedStream, GivesBackWhatIsNotSent) {
  ASSERT_EQ(stream.start(), ONI_STATUS_OK);
  { const auto picture = stream.next_picture(); }
  EXPECT_EQ(open_ni.out, 0);
  EXPECT_EQ(open_ni.handed, 0);
  EXPECT_TRUE(stream.next_picture()) << "and the next one can be made";
}

TEST_F(PushedStream, HasNoPictureBeforeStartAfterStopAndWithoutMemory) {
  EXPECT_FALSE(stream.next_picture());
  ASSERT_EQ(stream.start(), ONI_STATUS_OK);
  open_ni.has_memory = false;
  EXPECT_FALSE(stream.next_picture());
  open_ni.has_memory = true;
  EXPECT_TRUE(stream.next_picture());
  stream.stop();
  EXPECT_FALSE(stream.next_picture());
  EXPECT_EQ(owner.ended, 1);
}

TEST_F(PushedStream, StaysStoppedWhereItsCameraDoesNotBegin) {
  owner.answer = ONI_STATUS_ERROR;
  EXPECT_EQ(stream.start(), ONI_STATUS_ERROR);
  EXPECT_FALSE(stream.next_picture());
  stream.stop();
  EXPECT_EQ(owner.ended, 0);
}

TEST_F(PushedStream, StopsOnlyWhenThePictureOnItsWayHasArrived) {
  ASSERT_EQ(stream.start(), ONI_STATUS_OK);
  auto picture = stream.next_picture();
  ASSERT_TRUE(picture);
  std::atomic<bool> stopped = false;
  std::jthread stopping([&] {
    stream.stop();
    stopped = true;
  });
  std::this_thread::sleep_for(50ms);
  EXPECT_FALSE(stopped);
  picture->send(1, 1);
  stopping.join();
  EXPECT_TRUE(stopped);
  EXPECT_EQ(open_ni.handed, 1);
  EXPECT_EQ(owner.ended, 1);
}

// OpenNI2 asks for properties and sets them under locks that it also takes to be handed a picture: a lock of ours held
// meanwhile would be a deadlock in waiting.
TEST_F(PushedStream, AnswersWhileItHandsOverAPicture) {
  ASSERT_EQ(stream.start(), ONI_STATUS_OK);
  open_ni.when_handed = [this](const OniFrame&) {
    std::jthread other([this] {
      OniVideoMode mode{};
      int size = sizeof(mode);
      EXPECT_EQ(stream.getProperty(ONI_STREAM_PROPERTY_VIDEO_MODE, &mode, &size), ONI_STATUS_OK);
      EXPECT_EQ(mode.resolutionX, 4);
      EXPECT_EQ(stream.setProperty(ONI_STREAM_PROPERTY_VIDEO_MODE, &kTinier, sizeof(kTinier)),
                ONI_STATUS_OUT_OF_FLOW);
    });
  };
  auto picture = stream.next_picture();
  ASSERT_TRUE(picture);
  picture->send(1, 1);
  EXPECT_EQ(open_ni.handed, 1);
}

TEST_F(PushedStream, TakesAnotherModeOnlyWhileItStands) {
  EXPECT_EQ(stream.setProperty(ONI_STREAM_PROPERTY_VIDEO_MODE, &kTinier, sizeof(kTinier)), ONI_STATUS_OK);
  EXPECT_EQ(stream.getRequiredFrameSize(), 4);
  constexpr OniVideoMode unknown{ONI_PIXEL_FORMAT_DEPTH_1_MM, 5, 5, 30};
  EXPECT_EQ(stream.setProperty(ONI_STREAM_PROPERTY_VIDEO_MODE, &unknown, sizeof(unknown)),
            ONI_STATUS_NOT_SUPPORTED);
  EXPECT_EQ(stream.getRequiredFrameSize(), 4);
}

}  // namespace
}  // namespace copresence::drivers
