// OpenNI itself plays what OniWriter wrote.

#include <OpenNI.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "capture_server/recording/oni_writer.h"
#include "tests/support/open_ni.h"

namespace copresence::recording {
namespace {

using std::chrono::microseconds;

constexpr int kWidth = 160, kHeight = 120, kFrames = 5;

DepthImage depth_of(int frame, int largest) {
  DepthImage image(kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const unsigned hash = static_cast<unsigned>(i + 7 * frame) * 2654435761u;
    image.data()[i] = static_cast<std::uint16_t>(hash % 9 == 0   ? 0
                                                 : hash % 5 == 0 ? hash % unsigned(largest)
                                                                 : 700 + i / 40);
  }
  return image;
}

ColorImage color_of(int frame) {
  ColorImage image(kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    image.data()[i] = {static_cast<std::uint8_t>(i % kWidth), static_cast<std::uint8_t>(i / kWidth),
                       static_cast<std::uint8_t>(40 * frame)};
  }
  return image;
}

struct Case {
  const char* name;
  DepthCoding depth;
  std::optional<ColorCoding> color;
  DepthUnit unit;
  bool unfinished = false;  // its recorder died after a checkpoint and one more frame
};

class OniPlayback : public ::testing::TestWithParam<Case> {
 protected:
  static void SetUpTestSuite() { ASSERT_EQ(testing::start_open_ni(), openni::STATUS_OK); }
  static void TearDownTestSuite() { openni::OpenNI::shutdown(); }

  // One frame of a stream that plays by hand, or an invalid one after two seconds.
  static openni::VideoFrameRef next(openni::VideoStream& stream) {
    openni::VideoFrameRef frame;
    openni::VideoStream* streams[] = {&stream};
    int ready = -1;
    if (openni::OpenNI::waitForAnyStream(streams, 1, &ready, 2000) == openni::STATUS_OK)
      stream.readFrame(&frame);
    return frame;
  }
};

TEST_P(OniPlayback, DeliversEveryFrameAsItWasWritten) {
  const Case& wanted = GetParam();
  const int largest = wanted.unit == DepthUnit::kMillimetre ? 10000 : 65535;
  const auto path =
      std::filesystem::temp_directory_path() / ("copresence_play_" + std::to_string(getpid()) + ".oni");
  OniContent content;
  content.camera.model = {kWidth, kHeight, 150, 150, kWidth / 2, kHeight / 2, {}};
  content.camera.unit = wanted.unit;
  content.camera.registered = true;
  content.depth = wanted.depth;
  content.color = wanted.color;
  content.jpeg_quality = 95;
  {
    auto writer = OniWriter::create(path.string(), content, file::Existing::kReplace);
    ASSERT_TRUE(writer) << writer.error().what;
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(writer->write_depth(microseconds(5'000'000 + 33'333 * i), depth_of(i, largest)));
      if (wanted.color) {
        ASSERT_TRUE(writer->write_color(microseconds(5'007'000 + 33'333 * i), color_of(i)));
      }
      if (wanted.unfinished) {
        ASSERT_TRUE(writer->checkpoint());
      }
    }
    if (wanted.unfinished) {
      ASSERT_TRUE(writer->checkpoint());
      ASSERT_TRUE(writer->write_depth(microseconds(6'000'000), depth_of(0, largest)));
    } else {
      ASSERT_TRUE(writer->finish());
    }
  }

  openni::Device device;
  ASSERT_EQ(device.open(path.c_str()), openni::STATUS_OK) << openni::OpenNI::getExtendedError();
  EXPECT_EQ(device.hasSensor(openni::SENSOR_COLOR), wanted.color.has_value());
  ASSERT_EQ(device.getPlaybackControl()->setSpeed(-1), openni::STATUS_OK);
  device.getPlaybackControl()->setRepeatEnabled(false);
  openni::VideoStream depth, color;
  ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
  if (wanted.color) {
    ASSERT_EQ(color.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
  }
  EXPECT_EQ(device.getPlaybackControl()->getNumberOfFrames(depth), kFrames);
  EXPECT_NEAR(depth.getHorizontalFieldOfView(), 2 * std::atan(kWidth / 300.0), 1e-6);
  EXPECT_EQ(depth.getMaxPixelValue(), largest);
  ASSERT_EQ(depth.start(), openni::STATUS_OK);
  if (wanted.color) {
    ASSERT_EQ(color.start(), openni::STATUS_OK);
  }

  for (int i = 0; i < kFrames; ++i) {
    const auto frame = next(depth);
    ASSERT_TRUE(frame.isValid()) << "depth frame " << i;
    EXPECT_EQ(frame.getTimestamp(), 5'000'000u + 33'333u * unsigned(i));
    EXPECT_EQ(frame.getVideoMode().getPixelFormat(), wanted.unit == DepthUnit::kMillimetre
                                                         ? openni::PIXEL_FORMAT_DEPTH_1_MM
                                                         : openni::PIXEL_FORMAT_DEPTH_100_UM);
    const DepthImage truth = depth_of(i, largest);
    ASSERT_EQ(frame.getDataSize(), static_cast<int>(truth.pixels().size_bytes()));
    EXPECT_EQ(std::memcmp(frame.getData(), truth.data(), truth.pixels().size_bytes()), 0)
        << "depth frame " << i;
    if (!wanted.color) continue;
    const auto picture = next(color);
    ASSERT_TRUE(picture.isValid()) << "colour frame " << i;
    EXPECT_EQ(picture.getTimestamp(), 5'007'000u + 33'333u * unsigned(i));
    const ColorImage true_color = color_of(i);
    ASSERT_EQ(picture.getDataSize(), static_cast<int>(true_color.pixels().size_bytes()));
    const auto* got = static_cast<const std::uint8_t*>(picture.getData());
    const auto* put = reinterpret_cast<const std::uint8_t*>(true_color.data());
    int worst = 0;
    for (int b = 0; b < picture.getDataSize(); ++b)
      worst = std::max(worst, std::abs(int(got[b]) - int(put[b])));
    EXPECT_LE(worst, wanted.color == ColorCoding::kRaw ? 0 : 12) << "colour frame " << i;
  }

  depth.stop();
  if (wanted.color) color.stop();
  std::this_thread::sleep_for(
      std::chrono::milliseconds(50));  // OpenNI's player thread must be out before it closes
  device.close();
  depth.destroy();
  color.destroy();
  std::filesystem::remove(path);
}

INSTANTIATE_TEST_SUITE_P(
    Codings, OniPlayback,
    ::testing::Values(
        Case{"CodedDepthAndJpeg", DepthCoding::k16z, ColorCoding::kJpeg, DepthUnit::kMillimetre},
        Case{"CodedDepthAndRawColor", DepthCoding::k16z, ColorCoding::kRaw, DepthUnit::k100Micrometres},
        Case{"RawDepthAndJpeg", DepthCoding::kNone, ColorCoding::kJpeg, DepthUnit::kMillimetre},
        Case{"Unfinished", DepthCoding::k16z, ColorCoding::kJpeg, DepthUnit::kMillimetre, true},
        Case{"DepthAlone", DepthCoding::k16z, std::nullopt, DepthUnit::kMillimetre}),
    [](const auto& with) { return std::string(with.param.name); });

}  // namespace
}  // namespace copresence::recording
