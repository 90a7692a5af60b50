#include "render_client/display/view_colors.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <tuple>

namespace copresence::display {
namespace {

using renderer::MergedView;
using renderer::Origin;

/// A view of one pixel.
MergedView pixel(Rgba8 color, Origin origin, std::uint8_t camera = 0, float quality = 0.5F) {
  MergedView view;
  view.width = view.height = 1;
  view.texture = 7;
  view.color = Image<Rgba8>(1, 1, color);
  view.camera = Image<std::uint8_t>(1, 1, camera);
  view.quality = Image<float>(1, 1, quality);
  view.origin = Image<Origin>(1, 1, origin);
  return view;
}

Rgba8 recolored(ViewColors colors, MergedView view) {
  const std::array<std::size_t, 2> cameras{4, 1};  // The view shows the listed cameras 4 and 1.
  recolor(colors, cameras, view);
  return view.color(0, 0);
}

constexpr Rgba8 kWhite{255, 255, 255, 255};

TEST(ViewColors, ShowTheListedCameraThatAPixelIsFrom) {
  const auto opaque = [](Rgb8 color) { return Rgba8{color.r, color.g, color.b, 255}; };
  EXPECT_EQ(recolored(ViewColors::kLayers, pixel(kWhite, Origin::kSeen, 0)), opaque(layer_color(4)));
  EXPECT_EQ(recolored(ViewColors::kLayers, pixel(kWhite, Origin::kSeen, 1)), opaque(layer_color(1)));
}

TEST(ViewColors, GiveEightCamerasDifferentColors) {
  std::set<std::tuple<int, int, int>> colors;
  for (std::size_t i = 0; i < 8; ++i) {
    const Rgb8 color = layer_color(i);
    colors.insert({color.r, color.g, color.b});
  }
  EXPECT_EQ(colors.size(), 8U);
}

TEST(ViewColors, KeepTheShadesOfTheView) {
  const Rgba8 light = recolored(ViewColors::kLayers, pixel({200, 200, 200, 255}, Origin::kSeen));
  const Rgba8 dark = recolored(ViewColors::kLayers, pixel({50, 50, 50, 255}, Origin::kSeen));
  const Rgba8 remembered = recolored(ViewColors::kLayers, pixel({200, 200, 200, 255}, Origin::kRemembered));
  EXPECT_GT(light.b, dark.b);
  EXPECT_NEAR(remembered.b, light.b / 2, 2);
}

TEST(ViewColors, ShowPixelsThatNoCameraHasSeenWithoutColor) {
  for (const Origin origin : {Origin::kExtended, Origin::kEmpty}) {
    const MergedView view = pixel({200, 100, 0, 255}, origin, renderer::kNoCamera);
    const Rgba8 gray = recolored(ViewColors::kLayers, view);
    EXPECT_TRUE(gray.r == gray.g && gray.g == gray.b && gray.r > 0);
    EXPECT_EQ(recolored(ViewColors::kQuality, view), (Rgba8{0, 0, 0, 255}));
  }
}

TEST(ViewColors, RunFromBlueToRedWithTheQuality) {
  EXPECT_EQ(quality_color(0), quality_color(kLeastQuality));
  EXPECT_EQ(quality_color(100), quality_color(kBestQuality));
  EXPECT_GT(quality_color(kLeastQuality).b, quality_color(kLeastQuality).r);
  EXPECT_GT(quality_color(kBestQuality).r, quality_color(kBestQuality).b);
  EXPECT_EQ(quality_color(0.2F), (Rgb8{60, 200, 90})) << "the middle of the logarithmic scale is green";
}

TEST(ViewColors, LeaveTheCamerasColorsAlone) {
  MergedView view = pixel({1, 2, 3, 255}, Origin::kSeen);
  recolor(ViewColors::kCameras, {}, view);
  EXPECT_EQ(view.color(0, 0), (Rgba8{1, 2, 3, 255}));
  EXPECT_EQ(view.texture, 7U);
}

}  // namespace
}  // namespace copresence::display
