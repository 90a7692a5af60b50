#include "render_client/color_matching/color_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace copresence::color_matching {
namespace {

using std::chrono::milliseconds;

CameraModel small_model() {
  return {320, 240, 290, 290, 160, 120, {}};
}

// Colour of the wall at z = 2.5 m at a position in metres: large soft spots of many colours.
Eigen::Vector3f wall_color(double x, double y) {
  const auto wave = [](double v) { return static_cast<float>(0.45 + 0.25 * std::sin(v)); };
  return {wave(3 * x + y), wave(2 * y - x + 1), wave(2.5 * x - 2 * y + 2)};
}

Rgb8 to_pixel(const Eigen::Vector3f& color) {
  const auto byte = [](float v) {
    return static_cast<std::uint8_t>(std::clamp(255 * v + 0.5F, 0.0F, 255.0F));
  };
  return {byte(color.x()), byte(color.y()), byte(color.z())};
}

// A camera at `x_m` that sees the wall. `response` maps true colours to those of the camera.
struct Camera {
  RgbdFrame frame;
  PosedFrame posed;

  Camera(double x_m, const ColorCorrection& response) {
    const CameraModel model = small_model();
    frame.depth = DepthImage(model.width, model.height, std::uint16_t{2500});
    frame.state = StateImage(model.width, model.height, DepthState::kMeasured);
    frame.color.emplace(model.width, model.height);
    for (int y = 0; y < model.height; ++y) {
      for (int x = 0; x < model.width; ++x) {
        const Eigen::Vector3d at = unproject(model, {double(x), double(y)}, 2.5);
        (*frame.color)(x, y) = to_pixel(apply(response, wall_color(at.x() + x_m, at.y())));
      }
    }
    posed.model = model;
    posed.world_from_camera.translation.x() = x_m;
  }
  PosedFrame view() const {
    PosedFrame result = posed;
    result.frame = &frame;
    return result;
  }
};

ColorCorrection gains(float r, float g, float b, float offset) {
  ColorCorrection map = ColorCorrection::Zero();
  map.diagonal() << r, g, b;
  map.col(3).setConstant(offset);
  return map;
}

// Greatest difference of a channel between the corrected colours of a camera and those of the
// reference, on the wall, of 255.
float worst_error(const ColorCorrection& found, const ColorCorrection& response,
                  const ColorCorrection& reference) {
  float worst = 0;
  for (double x = -1; x < 1; x += 0.1) {
    const Eigen::Vector3f truth = wall_color(x, 0.5 * x);
    worst = std::max(worst,
                     (apply(found, apply(response, truth)) - apply(reference, truth)).cwiseAbs().maxCoeff());
  }
  return 255 * worst;
}

TEST(ColorMatcher, MapsASecondCameraToTheReference) {
  const ColorCorrection warm = gains(1.12F, 1.0F, 0.85F, 0.01F), cool = gains(0.9F, 1.0F, 1.1F, -0.01F);
  const Camera a(0, warm), b(0.4, cool);
  const auto maps = match_colors(std::vector{a.view(), b.view()});
  ASSERT_TRUE(maps[0] && maps[1]);
  EXPECT_EQ(*maps[0], ColorCorrection::Identity());
  EXPECT_LT(worst_error(*maps[1], cool, warm), 3.0F);
}

TEST(ColorMatcher, ReachesCamerasThatOnlyTheirNeighboursOverlap) {
  // In a row, 1.4 m apart; each sees 2.8 m of the wall. The fourth camera has no overlap with the
  // first.
  const ColorCorrection responses[] = {gains(1, 1, 1, 0), gains(0.9F, 1.05F, 1.1F, 0.01F),
                                       gains(1.1F, 0.95F, 1, -0.01F), gains(0.95F, 1, 0.88F, 0.02F)};
  std::vector<Camera> cameras;
  for (int i = 0; i < 4; ++i) cameras.emplace_back(1.4 * i, responses[i]);
  std::vector<PosedFrame> views;
  for (const Camera& camera : cameras) views.push_back(camera.view());
  const auto maps = match_colors(views);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(maps[i]) << i;
    EXPECT_LT(worst_error(*maps[i], responses[i], responses[0]), 4.0F) << i;
  }
}

TEST(ColorMatcher, SaysNothingOfCamerasThatShareNoSurface) {
  const Camera a(0, gains(1, 1, 1, 0)), b(5, gains(0.9F, 1, 1, 0));
  const auto maps = match_colors(std::vector{a.view(), b.view()});
  EXPECT_FALSE(maps[1]);
}

TEST(ColorMatcher, SaysNothingOfCamerasWithoutColourOrPlace) {
  Camera a(0, gains(1, 1, 1, 0)), b(0.3, gains(0.9F, 1, 1, 0));
  b.frame.color.reset();
  const auto maps = match_colors(std::vector{a.view(), b.view(), PosedFrame{}});
  EXPECT_FALSE(maps[1]);
  EXPECT_FALSE(maps[2]);
}

TEST(ColorMatcher, IsNotMisledByColoursThatAreCutOff) {
  // The second camera is overexposed: much of the wall is white.
  const ColorCorrection bright = gains(1.6F, 1.6F, 1.6F, 0.1F);
  const Camera a(0, gains(1, 1, 1, 0)), b(0.3, bright);
  const auto maps = match_colors(std::vector{a.view(), b.view()});
  ASSERT_TRUE(maps[1]);
  const Eigen::Vector3f dim(0.3F, 0.35F, 0.25F);
  EXPECT_LT(255 * (apply(*maps[1], apply(bright, dim)) - dim).cwiseAbs().maxCoeff(), 4.0F);
}

TEST(ColorMatcher, IsNotMisledBySomebodyWhomOnlyOneCameraSees) {
  Camera a(0, gains(1, 1, 1, 0)), b(0.3, gains(0.9F, 1, 1.1F, 0));
  // An object of one colour in front of the wall, in the first camera's frame only; a third of the
  // picture.
  for (int y = 0; y < 240; ++y) {
    for (int x = 100; x < 200; ++x) {
      a.frame.depth(x, y) = 1200;
      (*a.frame.color)(x, y) = {200, 40, 40};
    }
  }
  const auto maps = match_colors(std::vector{a.view(), b.view()});
  ASSERT_TRUE(maps[1]);
  EXPECT_LT(worst_error(*maps[1], gains(0.9F, 1, 1.1F, 0), gains(1, 1, 1, 0)), 3.0F);
}

TEST(SteadyCorrections, TakeTheFirstMatchAtOnceAndEaseInLaterOnes) {
  SteadyCorrections steady(2);
  EXPECT_EQ(steady.correction(1), ColorCorrection::Identity());
  steady.follow(
      std::vector<std::optional<ColorCorrection>>{ColorCorrection::Identity(), gains(0.9F, 0.9F, 0.9F, 0)},
      milliseconds(0));
  EXPECT_FLOAT_EQ(steady.correction(1)(0, 0), 0.9F);
  steady.follow(
      std::vector<std::optional<ColorCorrection>>{ColorCorrection::Identity(), gains(1.1F, 1.1F, 1.1F, 0)},
      milliseconds(500));
  EXPECT_GT(steady.correction(1)(0, 0), 0.9F);
  EXPECT_LT(steady.correction(1)(0, 0), 1.0F);
}

TEST(SteadyCorrections, KeepTheLastMatchWhereTheOverlapIsGone) {
  SteadyCorrections steady(2);
  steady.follow(
      std::vector<std::optional<ColorCorrection>>{ColorCorrection::Identity(), gains(0.9F, 0.9F, 0.9F, 0)},
      milliseconds(0));
  steady.follow(std::vector<std::optional<ColorCorrection>>{ColorCorrection::Identity(), std::nullopt},
                milliseconds(500));
  EXPECT_FLOAT_EQ(steady.correction(1)(0, 0), 0.9F);
}

}  // namespace
}  // namespace copresence::color_matching
