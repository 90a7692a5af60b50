#include "capture_server/recording/jpeg.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

namespace copresence::recording {
namespace {

ColorImage gradient(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image(x, y) = {static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(5 * y),
                     static_cast<std::uint8_t>(x + y)};
    }
  }
  return image;
}

std::vector<std::uint8_t> coded(const ColorImage& image, int quality = 90) {
  std::vector<std::uint8_t> bytes = {1, 2, 3};  // to be overwritten
  EXPECT_TRUE(JpegEncoder().encode(image, quality, bytes));
  return bytes;
}

TEST(Jpeg, APictureComesBackNearlyAsItWas) {
  const ColorImage image = gradient(64, 48);
  ColorImage back(64, 48);
  ASSERT_TRUE(decode_jpeg(coded(image, 95), back));
  int worst = 0;
  for (std::size_t i = 0; i < image.pixels().size(); ++i)
    worst = std::max(worst, std::abs(image.pixels()[i].g - back.pixels()[i].g));
  EXPECT_LE(worst, 12);
}

// What recordings, OpenNI2's player and the field's tools agree on: libjpeg's exact transform, 4:2:0, smooth upsampling.
TEST(Jpeg, BytesAndPixelsAreThoseOfOpenCv) {
  const ColorImage image = gradient(66, 50);
  const cv::Mat rgb(50, 66, CV_8UC3, const_cast<Rgb8*>(image.data()));
  cv::Mat bgr, shown;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> expected;
  cv::imencode(".jpg", bgr, expected, {cv::IMWRITE_JPEG_QUALITY, 85});
  EXPECT_EQ(coded(image, 85), expected);

  ColorImage back(66, 50);
  ASSERT_TRUE(decode_jpeg(expected, back));
  cv::cvtColor(cv::imdecode(expected, cv::IMREAD_COLOR), shown, cv::COLOR_BGR2RGB);
  EXPECT_TRUE(std::ranges::equal(back.pixels(), std::span(shown.ptr<Rgb8>(), shown.total())));
}

TEST(Jpeg, OneEncoderTakesPicturesOfAnySize) {
  JpegEncoder encoder;
  std::vector<std::uint8_t> bytes;
  for (const int width : {64, 16, 640, 1}) {
    const ColorImage image = gradient(width, 48);
    ASSERT_TRUE(encoder.encode(image, 90, bytes));
    EXPECT_EQ(bytes, coded(image));
  }
}

TEST(Jpeg, APictureTooWideForTheFormatIsRefusedWithAReason) {
  std::vector<std::uint8_t> bytes;
  const auto result = JpegEncoder().encode(ColorImage(70'000, 1), 90, bytes);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(result.error().what, "");
}

TEST(Jpeg, WhatIsNoPictureOfThisSizeIsRefused) {
  ColorImage image(64, 48);
  EXPECT_FALSE(decode_jpeg({}, image));
  constexpr std::string_view kText = "This is a sentence.";
  EXPECT_FALSE(decode_jpeg({reinterpret_cast<const std::uint8_t*>(kText.data()), kText.size()}, image));
  EXPECT_FALSE(decode_jpeg(coded(gradient(48, 64)), image));
}

TEST(Jpeg, DamagedBytesAreRefusedOrShownButNeverWorse) {
  const std::vector<std::uint8_t> whole = coded(gradient(64, 48));
  ColorImage image(64, 48);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    // In a block of its own, so that sanitizers see a read beyond it.
    const std::vector<std::uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const bool shown = decode_jpeg(cut, image);
    EXPECT_FALSE(shown && size < 20) << size;
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::vector<std::uint8_t> flipped = whole;
    flipped[i] ^= 0x55;
    decode_jpeg(flipped, image);
  }
  EXPECT_TRUE(decode_jpeg(whole, image));
}

}  // namespace
}  // namespace copresence::recording
