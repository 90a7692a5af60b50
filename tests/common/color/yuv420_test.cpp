#include "common/color/yuv420.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

namespace copresence::color {
namespace {

struct Yuv {
  int y, u, v;
  friend bool operator==(const Yuv&, const Yuv&) = default;
};

Yuv of_plain_color(Rgb8 color) {
  Picture picture;
  rgb_to_yuv420(ColorImage(2, 2, color), picture);
  return {picture.plane8(0)[0], picture.plane8(1)[0], picture.plane8(2)[0]};
}

int largest_difference(const ColorImage& a, const ColorImage& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgb8 p = a.pixels()[i], q = b.pixels()[i];
    largest = std::max({largest, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
  }
  return largest;
}

TEST(Yuv420, GivesTheKnownValuesOfPureColors) {
  EXPECT_EQ(of_plain_color({255, 0, 0}), (Yuv{76, 85, 255}));  // chroma of pure red is 255.5: it saturates
  EXPECT_EQ(of_plain_color({0, 255, 0}), (Yuv{150, 44, 21}));
  EXPECT_EQ(of_plain_color({0, 0, 255}), (Yuv{29, 255, 107}));
  EXPECT_EQ(of_plain_color({255, 255, 0}), (Yuv{226, 1, 149}));
  EXPECT_EQ(of_plain_color({0, 0, 0}), (Yuv{0, 128, 128}));
  EXPECT_EQ(of_plain_color({255, 255, 255}), (Yuv{255, 128, 128}));
}

TEST(Yuv420, KeepsGreysExactly) {
  ColorImage greys(256, 2), back;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 256; ++x) greys(x, y) = {std::uint8_t(x), std::uint8_t(x), std::uint8_t(x)};
  }
  Picture picture;
  rgb_to_yuv420(greys, picture);
  yuv420_to_rgb(picture, back);
  EXPECT_EQ(back, greys);
}

TEST(Yuv420, RoundTripBound) {
  std::mt19937 random(1);
  ColorImage image(640, 480), back;
  for (int y = 0; y < 480; y += 2) {
    for (int x = 0; x < 640; x += 2) {
      const auto bits = random();
      const Rgb8 color{std::uint8_t(bits), std::uint8_t(bits >> 8), std::uint8_t(bits >> 16)};
      image(x, y) = image(x + 1, y) = image(x, y + 1) = image(x + 1, y + 1) = color;
    }
  }
  Picture picture;
  rgb_to_yuv420(image, picture);
  yuv420_to_rgb(picture, back);
  EXPECT_LE(largest_difference(image, back), kRoundTripBound);
}

TEST(Yuv420, GivesAllFourPixelsTheMeanChroma) {
  ColorImage image(2, 2, {0, 0, 0});
  image(0, 0) = image(1, 1) = {0, 0, 200};
  Picture picture;
  rgb_to_yuv420(image, picture);
  EXPECT_EQ(picture.plane8(1)[0], 128 + 50);  // half of 200, times one half
}

TEST(Yuv420, TreatsEveryPixelOfAnyEvenSizeAlike) {
  for (const auto& [width, height] :
       {std::pair{2, 2}, {6, 4}, {126, 2}, {128, 4}, {130, 2}, {254, 6}, {322, 242}}) {
    const ColorImage plain(width, height, {200, 40, 90});
    ColorImage back;
    Picture picture;
    rgb_to_yuv420(plain, picture);
    yuv420_to_rgb(picture, back);
    ASSERT_TRUE(same_shape(plain, back));
    EXPECT_TRUE(std::all_of(back.pixels().begin(), back.pixels().end(),
                            [&](Rgb8 pixel) { return pixel == back(0, 0); }))
        << width << 'x' << height;
  }
}

TEST(Yuv420, TakesAnyPictureWithoutOverflow) {
  std::mt19937 random(2);
  Picture picture(PixelFormat::kYuv420, 320, 240);
  for (int plane = 0; plane < 3; ++plane) {
    for (auto& sample : picture.plane8(plane)) sample = (random() & 1) ? 255 : 0;
  }
  ColorImage image;
  yuv420_to_rgb(picture, image);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double luma = picture.plane8(0)[y * 320 + x];
      const double cb = picture.plane8(1)[(y / 2) * 160 + x / 2] - 128.0;
      const double cr = picture.plane8(2)[(y / 2) * 160 + x / 2] - 128.0;
      ASSERT_NEAR(image(x, y).r, std::clamp(luma + 1.402 * cr, 0.0, 255.0), 0.51);
      ASSERT_NEAR(image(x, y).g, std::clamp(luma - 0.344136 * cb - 0.714136 * cr, 0.0, 255.0), 0.51);
      ASSERT_NEAR(image(x, y).b, std::clamp(luma + 1.772 * cb, 0.0, 255.0), 0.51);
    }
  }
}

}  // namespace
}  // namespace copresence::color
