#include "simulation/sensor/frame_marker.h"

#include <gtest/gtest.h>

#include "simulation/scene/noise.h"

namespace copresence::simulation {
namespace {

ColorImage picture(std::uint8_t shade) {
  ColorImage made(640, 480);
  for (Rgb8& pixel : made.pixels()) pixel = {shade, shade, shade};
  return made;
}

TEST(FrameMarker, IsReadAsItWasDrawn) {
  for (const std::uint32_t number : {0u, 1u, 0x80000000u, 0xFFFFFFFFu, 123456789u}) {
    ColorImage shown = picture(90);
    draw_marker(number, shown.pixels(), shown.width());
    EXPECT_EQ(read_marker(shown), number);
  }
}

TEST(FrameMarker, SurvivesWhatVideoCodingDoes) {
  ColorImage shown = picture(90);
  draw_marker(0xC0FFEE42u, shown.pixels(), shown.width());
  std::uint32_t i = 0;
  for (Rgb8& pixel : shown.pixels())
    pixel.g = static_cast<std::uint8_t>(std::clamp(pixel.g + 30.0f * normal(hash(7, ++i)), 0.0f, 255.0f));
  EXPECT_EQ(read_marker(shown), 0xC0FFEE42u);
}

TEST(FrameMarker, IsNotSeenWhereThereIsNone) {
  EXPECT_EQ(read_marker(picture(0)), std::nullopt);
  EXPECT_EQ(read_marker(picture(255)), std::nullopt);
  EXPECT_EQ(read_marker(ColorImage(320, 240)), std::nullopt);
}

}  // namespace
}  // namespace copresence::simulation
