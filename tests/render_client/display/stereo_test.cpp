#include "render_client/display/stereo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/render_client/renderer/rendering.h"

namespace copresence::display {
namespace {

using viewpoint::ViewPose;

constexpr Stereo with(StereoMode mode) {
  return {.mode = mode, .eye_distance_m = 0.06, .screen_distance_m = 1.5};
}

constexpr std::array kWithTwoEyes = {StereoMode::kSide, StereoMode::kTop, StereoMode::kAnaglyph,
                                     StereoMode::kRows};

ViewPose head() {
  ViewPose pose;
  pose.intrinsics = camera_from_field_of_view(64, 48, 1.0);
  return pose;
}

/// The display's pixel at which an eye sees a point of the head's frame.
Eigen::Vector2d display_pixel(const viewpoint::Eye& eye, const Eigen::Vector3d& point) {
  const ViewPose pose = viewpoint::pose_of_eye(head(), eye);
  const Eigen::Vector2d pixel = project(pose.intrinsics, pose.world_from_eye.inverse() * point);
  return {eye.pixels.first_column + eye.pixels.column_step * pixel.x(),
          eye.pixels.first_row + eye.pixels.row_step * pixel.y()};
}

Eigen::Vector2d parallax(const Stereo& stereo, const Eigen::Vector3d& point) {
  const auto eyes = eyes_of(stereo);
  return display_pixel(eyes.at(1), point) - display_pixel(eyes.at(0), point);
}

TEST(Stereo, HasNoParallaxInThePlaneOfTheScreen) {
  for (const StereoMode mode : kWithTwoEyes) {
    for (const double x : {-0.7, 0.0, 0.4})
      EXPECT_NEAR(parallax(with(mode), {x, 0.3, 1.5}).norm(), 0, 1e-9) << name_of(mode);
  }
}

TEST(Stereo, HasTheParallaxOfSimilarTriangles) {
  for (const StereoMode mode : kWithTwoEyes) {
    const double focal = head().intrinsics.fx;
    // Eye distance 0.06 m, screen at 1.5 m: focal * 0.06 * (1 / 1.5 - 1 / z), to the right behind the screen.
    EXPECT_NEAR(parallax(with(mode), {0.1, 0, 3}).x(), focal * 0.06 * (1 / 1.5 - 1 / 3.0), 1e-9);
    EXPECT_NEAR(parallax(with(mode), {0.1, 0, 1}).x(), focal * 0.06 * (1 / 1.5 - 1), 1e-9);
    EXPECT_NEAR(parallax(with(mode), {0.1, 0.2, 3}).y(), 0, 1e-9);
  }
}

TEST(Stereo, ExchangesTheEyesIfTheirDistanceIsNegative) {
  Stereo stereo = with(StereoMode::kSide);
  const double parallax_before = parallax(stereo, {0, 0, 3}).x();
  stereo.eye_distance_m = -stereo.eye_distance_m;
  EXPECT_NEAR(parallax(stereo, {0, 0, 3}).x(), -parallax_before, 1e-9);
}

TEST(Stereo, WithoutStereoThereIsOneEyeInTheMiddle) {
  const auto eyes = eyes_of(with(StereoMode::kNone));
  ASSERT_EQ(eyes.size(), 1U);
  EXPECT_EQ(viewpoint::pose_of_eye(head(), eyes[0]), head());
}

/// Number 10 y + x in red for the left eye, and 100 more in green and blue for the right eye.
Image<Rgba8> numbered(int width, int height, int first) {
  Image<Rgba8> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto value = static_cast<std::uint8_t>(first + 10 * y + x);
      image(x, y) = {value, static_cast<std::uint8_t>(value + 1), static_cast<std::uint8_t>(value + 2), 255};
    }
  }
  return image;
}

TEST(Stereo, SideBySideHasTheLeftEyeInTheLeftHalf) {
  const Image<Rgba8> left = numbered(2, 3, 0), right = numbered(2, 3, 100);
  Image<Rgba8> display;
  compose(StereoMode::kSide, left, right, display);
  ASSERT_EQ(display.width(), 4);
  ASSERT_EQ(display.height(), 3);
  EXPECT_EQ(display(1, 2), left(1, 2));
  EXPECT_EQ(display(3, 2), right(1, 2));
}

TEST(Stereo, TopAndBottomHasTheLeftEyeAbove) {
  const Image<Rgba8> left = numbered(2, 3, 0), right = numbered(2, 3, 100);
  Image<Rgba8> display;
  compose(StereoMode::kTop, left, right, display);
  ASSERT_EQ(display.width(), 2);
  ASSERT_EQ(display.height(), 6);
  EXPECT_EQ(display(1, 2), left(1, 2));
  EXPECT_EQ(display(1, 5), right(1, 2));
}

TEST(Stereo, AnaglyphHasRedOfTheLeftEyeAndTheRestOfTheRight) {
  Image<Rgba8> display;
  compose(StereoMode::kAnaglyph, numbered(2, 3, 0), numbered(2, 3, 100), display);
  EXPECT_EQ(display(1, 2), (Rgba8{21, 122, 123, 255}));
}

TEST(Stereo, RowsAlternateFromTheLeftEyeOn) {
  const Image<Rgba8> left = numbered(2, 3, 0), right = numbered(2, 3, 100);
  Image<Rgba8> display;
  compose(StereoMode::kRows, left, right, display);
  ASSERT_EQ(display.height(), 6);
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(display(1, 2 * y), left(1, y));
    EXPECT_EQ(display(1, 2 * y + 1), right(1, y));
  }
}

/// The greatest difference in red between the pictures that both eyes see of a wall.
int greatest_difference(double wall_m) {
  renderer::Looking camera(renderer::kinect_model(), renderer::wall(wall_m));
  const auto eyes = eyes_of(with(StereoMode::kAnaglyph));
  const auto left = renderer::render({&camera}, viewpoint::pose_of_eye(head(), eyes[0])),
             right = renderer::render({&camera}, viewpoint::pose_of_eye(head(), eyes[1]));
  int greatest = 0;
  for (int y = 8; y < 40; ++y) {
    for (int x = 8; x < 56; ++x)
      greatest = std::max(greatest, std::abs(left.color(x, y).r - right.color(x, y).r));
  }
  return greatest;
}

TEST(Stereo, ShowsAWallInThePlaneOfTheScreenToBothEyesAlike) {
  EXPECT_LE(greatest_difference(1.5), 1);
  EXPECT_GE(greatest_difference(3), 3);
}

TEST(Stereo, NamesAreThoseOfTheFlag) {
  for (const StereoMode mode : kStereoModes) EXPECT_EQ(parse_stereo(name_of(mode)), mode);
  for (const char* const name : {"", "Side", "sides", "row"}) EXPECT_FALSE(parse_stereo(name)) << name;
}

}  // namespace
}  // namespace copresence::display
