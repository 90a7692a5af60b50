#include "capture_server/encoding/frame_encoding.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/flow/worker_pool.h"
#include "common/video/frame_decoder.h"
#include "tests/common/depth/scenes.h"

namespace copresence::server {
namespace {

constexpr int kWidth = 160, kHeight = 120;

sensor::SensorDescription small_sensor() {
  sensor::SensorDescription sensor;
  sensor.depth = {kWidth, kHeight, 146, 146, 79.5, 59.5, {}};
  sensor.color = sensor.depth;
  sensor.has_color = true;
  sensor.registered = true;
  return sensor;
}

/// A picture of all levels of a Kinect from near to far, in mm.
RgbdFrame walls(int near, int far, std::uint64_t sequence) {
  RgbdFrame frame;
  frame.metadata.sequence = sequence;
  frame.depth.resize(kWidth, kHeight);
  frame.state = StateImage(kWidth, kHeight, DepthState::kMeasured);
  frame.color.emplace(kWidth, kHeight);
  for (std::size_t i = 0; i < frame.depth.pixels().size(); ++i) {
    const int z = near + static_cast<int>(i * 7919 + sequence * 31) % (far - near);
    frame.depth.data()[i] = depth::testing::kinect_level(z);
    const auto gray = static_cast<std::uint8_t>(i / kWidth + 3 * sequence);
    frame.color->data()[i] = {gray, gray, gray};
  }
  return frame;
}

// The caller requests keyframes. The depth codec may make further keyframes by itself.
TEST(FrameEncoding, SendsFramesThatDecodeThoughDepthMakesAKeyframeOfItsOwn) {
  auto encoding = FrameEncoding::open(small_sensor(), nullptr, EncodingSettings{});
  ASSERT_TRUE(encoding) << encoding.error().what;
  auto decoder = video::FrameDecoder::open(encoding->description());
  ASSERT_TRUE(decoder) << decoder.error().what;
  flow::WorkerPool workers(2, "encode");
  int keyframes = 0;
  for (std::uint64_t sequence = 1; sequence <= 200; ++sequence) {
    RgbdFrame frame = sequence <= 100 ? walls(2500, 4000, sequence) : walls(600, 1000, sequence);
    const auto encoded = encoding->encode(std::move(frame), sequence == 1, &workers);
    ASSERT_TRUE(encoded) << encoded.error().what;
    keyframes += encoded->keyframe;
    const auto decoded = decoder->decode(*encoded);
    ASSERT_TRUE(decoded) << "frame " << sequence << ": " << decoded.error().what;
    EXPECT_TRUE(decoded->color);
  }
  EXPECT_GT(keyframes, 1) << "the scene has left its levels";
}

// This wall has 53 disparity steps. A step has four codes at a constant QP, and two at a bitrate.
TEST(FrameEncoding, SpacesDepthCodesByTheBitRateFromTheBeginningAndWhenItChanges) {
  EncodingSettings settings;
  settings.encoder.depth_kbps = 5000;
  auto encoding = FrameEncoding::open(small_sensor(), nullptr, settings);
  ASSERT_TRUE(encoding) << encoding.error().what;
  auto decoder = video::FrameDecoder::open(encoding->description());
  ASSERT_TRUE(decoder) << decoder.error().what;
  std::uint64_t sequence = 1;
  const auto codes = [&] {
    const auto encoded = encoding->encode(walls(2500, 4000, sequence), sequence == 1);
    ++sequence;
    EXPECT_TRUE(encoded);
    const auto decoded = decoder->decode(*encoded);
    EXPECT_TRUE(decoded);
    const auto samples = decoded->depth.picture.plane10();
    const auto [least, most] = std::minmax_element(samples.begin(), samples.end());
    return *most - *least;
  };
  EXPECT_NEAR(codes(), 106, 20);
  EncoderSettings constant_qp;
  constant_qp.depth_qp = 12;
  ASSERT_TRUE(encoding->change_settings(constant_qp));
  EXPECT_NEAR(codes(), 211, 20);
  ASSERT_TRUE(encoding->change_settings(settings.encoder));
  EXPECT_NEAR(codes(), 106, 20);
}

/// A still wall whose depth is wrong by one level in every third pixel. These pixels change with
/// each frame.
RgbdFrame noisy_wall(std::uint64_t sequence) {
  RgbdFrame frame = walls(2000, 2001, sequence);
  for (std::size_t i = 0; i < frame.depth.pixels().size(); ++i) {
    if ((i * 7919 + sequence * 31) % 3 == 0) frame.depth.data()[i] = depth::testing::kinect_level(2012);
  }
  return frame;
}

/// Returns the share of pixels that decode to the measured value, over the last ten of 30 frames.
double share_as_measured(const EncodingSettings& settings) {
  auto encoding = FrameEncoding::open(small_sensor(), nullptr, settings);
  EXPECT_TRUE(encoding) << encoding.error().what;
  const StreamDescription& stream = encoding->description();
  auto video = video::FrameDecoder::open(stream);
  auto decoder =
      depth::Decoder::open(stream.codec, {kWidth, kHeight, stream.unit, stream.range, stream.noise});
  double equal = 0, pixels = 0;
  for (std::uint64_t sequence = 1; sequence <= 30; ++sequence) {
    const RgbdFrame frame = noisy_wall(sequence);
    const auto encoded = encoding->encode(RgbdFrame(frame), sequence == 1);
    const auto planes = video->decode(*encoded);
    DepthImage depth;
    StateImage states;
    EXPECT_TRUE(decoder->decode(planes->depth, depth, states));
    if (sequence <= 20) continue;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      equal += depth.data()[i] == frame.depth.data()[i];
      ++pixels;
    }
  }
  return equal / pixels;
}

TEST(FrameEncoding, FiltersOverTimeAndSaysSo) {
  EncodingSettings settings;
  settings.name = "camera";
  settings.codec = "quantized";
  settings.encoder.depth_qp = 8;
  EXPECT_TRUE(FrameEncoding::open(small_sensor(), nullptr, settings)->description().is_temporally_filtered);
  EXPECT_LT(share_as_measured(settings), 0.8);
  settings.temporal_filter = temporal_filter::Mode::kOff;
  EXPECT_FALSE(FrameEncoding::open(small_sensor(), nullptr, settings)->description().is_temporally_filtered);
}

TEST(FrameEncoding, LeavesLosslessDepthUntouched) {
  EncodingSettings settings;
  settings.name = "camera";
  settings.codec = "quantized";
  settings.encoder.depth_qp = 0;
  EXPECT_FALSE(FrameEncoding::open(small_sensor(), nullptr, settings)->description().is_temporally_filtered);
  EXPECT_EQ(share_as_measured(settings), 1);
}

}  // namespace
}  // namespace copresence::server
