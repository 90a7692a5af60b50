#include "common/depth/levels/quantized_codec.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "common/depth/depth_codec.h"
#include "tests/common/depth/scenes.h"
#include "tests/common/depth/stream_without_video.h"

namespace copresence::depth {
namespace {

using testing::flat_scene;
using ::testing::HasSubstr;
using testing::kinect_scene;
using testing::Scene;
using testing::StreamWithoutVideo;

class CodedByLevels : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Codecs, CodedByLevels, ::testing::Values("quantized", "adaptive"),
                         [](const auto& param) { return std::string(param.param); });

TEST_P(CodedByLevels, IsExactWhileLevelsAppearAndFilledPixelsAddNone) {
  StreamWithoutVideo stream(GetParam());
  for (int time = 0; time < 8; ++time) {
    Scene scene = kinect_scene(160, 120, time);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      // Values between the levels, as hole filling makes them.
      if (scene.state.data()[i] == DepthState::kFilled) scene.depth.data()[i] += 3;
    }
    const PlanarDepth planes = stream.send(scene);
    if (time >= 6) {
      EXPECT_LT(planes.table.size(), 40u);
    }
    ASSERT_TRUE(stream.receive(planes));
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      if (scene.state.data()[i] == DepthState::kMeasured) {
        ASSERT_EQ(stream.depth.data()[i], scene.depth.data()[i]);
      } else if (scene.state.data()[i] == DepthState::kFilled) {
        ASSERT_EQ(stream.depth.data()[i], testing::kinect_level(stream.depth.data()[i]));
      }
    }
  }
}

// A ramp over more values than there are codes.
Scene ramp(int width, int height) {
  Scene scene = flat_scene(width, height, 400);
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    const auto column = i % static_cast<std::size_t>(width), row = i / static_cast<std::size_t>(width);
    scene.depth.data()[i] = static_cast<std::uint16_t>(2500 + column + 10 * row);
  }
  return scene;
}

// Error in millimetres at depth z if 1024 codes are even in 1/z over the range.
double half_a_code(double z) {
  return z * z * (1 / 400.0 - 1 / 5000.0) / 2046 * 1.02 + 0.5;
}

TEST_P(CodedByLevels, RefusesMoreLevelsThanCodesOnlyWhereItMustBeExact) {
  StreamWithoutVideo stream(GetParam());
  stream.encoder.set_lossless(true);
  stream.carry(kinect_scene(160, 120));
  const Scene scene = ramp(160, 120);
  const auto refused = stream.encoder.encode(scene.depth, scene.state, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(refused.error().what, HasSubstr("1024"));

  stream.encoder.set_lossless(false);
  const PlanarDepth planes = stream.send(scene);
  EXPECT_TRUE(planes.keyframe);
  ASSERT_TRUE(stream.receive(planes));
  for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
    const double z = scene.depth.data()[i];
    ASSERT_NEAR(stream.depth.data()[i], z, half_a_code(z) + 1);
  }
}

std::vector<std::uint16_t> advertised_levels() {
  std::vector<std::uint16_t> levels;
  for (int z = 400; z <= 5000; ++z) levels.push_back(testing::kinect_level(z));
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

TEST_P(CodedByLevels, LearnsNothingThatTheSensorHasTold) {
  StreamWithoutVideo stream(GetParam());
  stream.encoder.set_sensor_levels(advertised_levels());
  for (int time = 0; time < 6; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    const PlanarDepth planes = stream.send(scene);
    EXPECT_EQ(planes.table.empty(), time > 0);
    ASSERT_TRUE(stream.receive(planes));
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      if (scene.state.data()[i] != DepthState::kMeasured) continue;
      ASSERT_EQ(stream.depth.data()[i], scene.depth.data()[i]);
    }
  }
}

TEST_P(CodedByLevels, IsExactWhereTheSensorHasToldTooManyLevelsOrWrongOnes) {
  // There are 1150 levels, or 511 levels that leave no codes for the scene's own levels.
  for (const int step : {4, 9}) {
    StreamWithoutVideo stream(GetParam());
    std::vector<std::uint16_t> advertised;
    for (int z = 401; z <= 5000; z += step) advertised.push_back(static_cast<std::uint16_t>(z));
    stream.encoder.set_sensor_levels(advertised);
    for (int time = 0; time < 4; ++time) {
      Scene scene = flat_scene(160, 120, 400);
      for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i)
        scene.depth.data()[i] =
            static_cast<std::uint16_t>(1000 + (i + 100 * static_cast<std::size_t>(time)) % 900);
      stream.carry(scene);
      ASSERT_EQ(stream.depth, scene.depth);
    }
  }
}

TEST(Adaptive, GivesNoCodeToLevelsThatWereOnlyTold) {
  StreamWithoutVideo advertised("adaptive"), learnt("adaptive");
  advertised.encoder.set_sensor_levels(advertised_levels());
  advertised.encoder.set_lossless(false);
  learnt.encoder.set_lossless(false);
  const Scene scene = kinect_scene(160, 120);
  EXPECT_EQ(advertised.send(scene).picture, learnt.send(scene).picture);
}

TEST(Adaptive, IsQuantizedWhereNothingIsLost) {
  StreamWithoutVideo adaptive("adaptive"), quantized("quantized");
  for (int time = 0; time < 4; ++time) {
    const Scene scene = kinect_scene(160, 120, time);
    EXPECT_EQ(adaptive.send(scene).residuals, quantized.send(scene).residuals);
  }
}

TEST(Adaptive, LosesNothingBeforeVideoCodingAtAnyBitrate) {
  for (const int kbps : {1, 50, 200, 1000, 20000}) {
    StreamWithoutVideo stream("adaptive");
    stream.encoder.set_lossless(false);
    stream.encoder.set_bitrate(kbps, 30);
    for (int time = 0; time < 4; ++time) {
      const Scene scene = kinect_scene(160, 120, time);
      stream.carry(scene);
      for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
        if (scene.state.data()[i] != DepthState::kMeasured) continue;
        ASSERT_EQ(stream.depth.data()[i], scene.depth.data()[i]) << kbps;
      }
    }
  }
}

TEST(Adaptive, TakesTheSpacingOfABitrateAtTheNextKeyframe) {
  StreamWithoutVideo stream("adaptive");
  stream.encoder.set_lossless(false);
  const Scene scene = kinect_scene(160, 120);
  const auto codes = [&](bool keyframe) {
    const Picture picture = stream.send(scene, keyframe).picture;
    const auto [least, most] = std::minmax_element(picture.plane10().begin(), picture.plane10().end());
    return *most - *least;
  };
  const int constant_qp = codes(true);
  stream.encoder.set_bitrate(1000, 30);
  EXPECT_EQ(codes(false), constant_qp);
  const int plenty = codes(true);
  EXPECT_LT(plenty, constant_qp);
  stream.encoder.set_bitrate(1, 30);
  EXPECT_LT(codes(true), plenty);
  stream.encoder.set_bitrate(std::nullopt, 30);
  EXPECT_EQ(codes(true), constant_qp);
}

TEST(Adaptive, LaysItsTableOutAnewWhereTheSceneHasLeftIt) {
  StreamWithoutVideo stream("adaptive");
  stream.encoder.set_lossless(false);
  const auto wall = [](int near, int far, int time) {
    Scene scene = flat_scene(160, 120, 1000);
    for (std::size_t i = 0; i < scene.depth.pixels().size(); ++i) {
      const int z = near + static_cast<int>(i * 7919 + static_cast<std::size_t>(time) * 31) % (far - near);
      scene.depth.data()[i] = testing::kinect_level(z);
    }
    return scene;
  };
  const auto carry = [&](const Scene& scene) {
    const PlanarDepth planes = stream.send(scene);
    EXPECT_TRUE(stream.receive(planes));
    return planes.keyframe;
  };
  int keyframes = 0;
  for (int time = 0; time < 200; ++time) keyframes += carry(wall(2500, 4000, time));
  EXPECT_EQ(keyframes, 1) << "the first";
  for (int time = 0; time < 200; ++time) keyframes += carry(wall(600, 1000, time));
  EXPECT_EQ(keyframes, 2) << "and one after the scene has changed";
}

}  // namespace
}  // namespace copresence::depth
