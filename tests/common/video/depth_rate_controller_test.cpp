#include "common/video/depth_rate_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "common/video/frame_encoder.h"
#include "tests/common/video/moving_scene.h"

namespace copresence::video {
namespace {

constexpr double kFps = 30;

double kbit(std::size_t bytes) {
  return static_cast<double>(bytes) * 8 / 1000;
}

TEST(DepthRateController, GivesThePictureWhatTheSideDataLeaves) {
  const DepthRateController controller(1000, kFps);
  const double alone = controller.picture_rate(0).kbps;
  EXPECT_NEAR(alone, 1000, 20);
  EXPECT_NEAR(controller.picture_rate(1000).kbps, alone - 240, 1e-9);
}

TEST(DepthRateController, LetsAPictureTakeLessThanThreeFramesWorthAtOnce) {
  EXPECT_LT(DepthRateController(900, kFps).picture_rate(0).buffer_kbit, 90);
}

TEST(DepthRateController, MeetsTheMeanOfAnEncoderThatSpendsLessThanItMay) {
  DepthRateController controller(2000, kFps);
  double spent = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const std::size_t side = frame % 2 ? 700 : 300;
    const auto picture =
        static_cast<std::size_t>(0.87 * controller.picture_rate(side).kbps * 1000 / 8 / kFps);
    controller.spent(side + picture);
    spent += kbit(side + picture);
  }
  EXPECT_NEAR(spent / 10, 2000, 100);
}

TEST(DepthRateController, MeetsTheMeanOfAnEncoderThatLeavesAQuarter) {
  DepthRateController controller(2000, kFps);
  double spent = 0;
  for (int frame = 0; frame < 300; ++frame) {
    const auto bytes = static_cast<std::size_t>(0.75 * controller.picture_rate(0).kbps * 1000 / 8 / kFps);
    controller.spent(bytes);
    spent += kbit(bytes);
  }
  EXPECT_NEAR(spent / 10, 2000, 100);
}

TEST(DepthRateController, LeavesThePicturesAfterAKeyframeTheMostOfTheirShareEvenWhereTheMaskTakesMost) {
  constexpr std::size_t kMask = 3200;  // bytes, of 4167 a frame
  DepthRateController controller(1000, kFps);
  const double usual = controller.picture_rate(kMask).kbps;
  controller.spent(10'000);  // as much as a keyframe may take
  EXPECT_GT(controller.picture_rate(kMask).kbps, 0.8 * usual);
}

TEST(DepthRateController, PaysMoreBackWithinASecondAndKeepsNoMoreThanAFewFramesForLater) {
  DepthRateController controller(1000, kFps);
  const double usual = controller.picture_rate(0).kbps;
  controller.spent(25'000);  // six frames' worth
  EXPECT_LT(controller.picture_rate(0).kbps, 0.6 * usual);
  for (int frame = 0; frame < 29; ++frame) {
    controller.spent(static_cast<std::size_t>(controller.picture_rate(0).kbps * 1000 / 8 / kFps));
  }
  EXPECT_NEAR(controller.picture_rate(0).kbps, usual,
              usual / 10);  // what is left is a keyframe's usual level
  for (int frame = 0; frame < 300; ++frame) controller.spent(0);
  EXPECT_LT(controller.picture_rate(0).kbps, 1.5 * usual);
}

TEST(DepthRateController, GivesThePictureALittleEvenWhenThereIsNothingLeft) {
  DepthRateController controller(100, kFps);
  for (int frame = 0; frame < 10; ++frame) {
    EXPECT_GT(controller.picture_rate(5000).kbps, 0);
    controller.spent(5000);
  }
}

/// A noisy scene with side data and a requested keyframe, encoded at a bit rate.
class RateOfAStream : public testing::TestWithParam<PixelFormat> {
 protected:
  void run(int frames) {
    for (int i = 0; i < frames; ++i) {
      const std::uint64_t sequence = bytes.size() + 1;
      const bool keyframe = sequence == 1 || sequence % 130 == 0;
      PlanarFrame frame = moving_frame(stream, sequence, keyframe);
      frame.depth.validity_mask.resize(keyframe ? 600 : 60 + sequence % 80, 0x5A);
      bytes.push_back(encoder.encode(frame).value().depth.size());
      keyframes.push_back(keyframe);
    }
  }
  double second_kbps(std::size_t first) const {
    return kbit(std::accumulate(bytes.begin() + static_cast<std::ptrdiff_t>(first),
                                bytes.begin() + static_cast<std::ptrdiff_t>(first + 30), std::size_t{0}));
  }

  StreamDescription stream = [] {
    StreamDescription made = small_stream(GetParam(), false);
    made.model = camera_from_field_of_view(160, 120, 1.0, 0.8);
    return made;
  }();
  FrameEncoder encoder = FrameEncoder::open(stream, {.depth_kbps = 300}).value();
  std::vector<std::size_t> bytes;
  std::vector<bool> keyframes;
};

TEST_P(RateOfAStream, IsKeptInEverySecondInTheMeanAndByEveryFrame) {
  run(300);
  for (std::size_t first = 0; first + 30 <= bytes.size(); ++first) {
    EXPECT_LE(second_kbps(first), 1.1 * 300) << "second from frame " << first;
  }
  const double mean = kbit(std::accumulate(bytes.begin(), bytes.end(), std::size_t{0})) / 10;
  EXPECT_NEAR(mean, 300, 30);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_TRUE(keyframes[i] || kbit(bytes[i]) <= 3 * 10) << "frame " << i;
  }
}

TEST_P(RateOfAStream, FollowsAChangeWhileRunning) {
  run(60);
  EXPECT_FALSE(encoder.change({.depth_kbps = 150}).value());
  run(60);
  EXPECT_NEAR(second_kbps(90), 150, 15);
  EXPECT_FALSE(encoder.change({.depth_kbps = 400}).value());
  run(60);
  EXPECT_NEAR(second_kbps(150), 400, 40);
}

INSTANTIATE_TEST_SUITE_P(DepthRateController, RateOfAStream,
                         testing::Values(PixelFormat::kGray10, PixelFormat::kYuv420),
                         [](const auto& param) { return std::string(name(param.param)); });

}  // namespace
}  // namespace copresence::video
