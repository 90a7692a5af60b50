#include "capture_server/registration/registration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace copresence::registration {
namespace {

constexpr double kBoardZ = 1.0, kWallZ = 2.5;  // metres, as the depth camera sees them

CameraModel depth_camera() {
  return {160, 120, 145, 145, 80, 60, {}};
}

CameraModel wide_color_camera() {
  return {320, 240, 262, 262, 158, 122, {0.05, -0.1, 0.001, -0.001, 0, 0, 0, 0}};
}

Rigid3 beside() {
  return {Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix(),
          Eigen::Vector3d(-0.05, 0.002, 0)};
}

bool on_board(double x, double y) {
  return std::abs(x) < 0.12 && std::abs(y) < 0.12;
}

/// A red board before a wall whose green and blue tell the place.
Rgb8 color_of(const Eigen::Vector3d& point) {
  if (point.z() < 0.5 * (kBoardZ + kWallZ)) return {200, 20, 20};
  return {0, static_cast<std::uint8_t>(128 + 70 * point.x()),
          static_cast<std::uint8_t>(128 + 70 * point.y())};
}

/// The scene's point that `camera` sees at `pixel`.
Eigen::Vector3d see(const CameraModel& camera, const Rigid3& depth_from_camera, double u, double v) {
  const Eigen::Vector3d eye = depth_from_camera.translation;
  const Eigen::Vector3d ray = depth_from_camera.rotation * unproject(camera, {u, v}, 1.0);
  const Eigen::Vector3d board = eye + ray * ((kBoardZ - eye.z()) / ray.z());
  if (on_board(board.x(), board.y())) return board;
  return eye + ray * ((kWallZ - eye.z()) / ray.z());
}

RgbdFrame photograph(const SensorCameras& cameras) {
  RgbdFrame frame;
  frame.depth = DepthImage(cameras.depth.width, cameras.depth.height);
  frame.state = StateImage(cameras.depth.width, cameras.depth.height, DepthState::kMeasured);
  for (int y = 0; y < cameras.depth.height; ++y) {
    for (int x = 0; x < cameras.depth.width; ++x) {
      frame.depth(x, y) = static_cast<std::uint16_t>(std::lround(see(cameras.depth, {}, x, y).z() * 1000));
    }
  }
  if (!cameras.color) return frame;
  frame.color = ColorImage(cameras.color->width, cameras.color->height);
  const Rigid3 depth_from_color = cameras.color_from_depth.inverse();
  for (int y = 0; y < cameras.color->height; ++y) {
    for (int x = 0; x < cameras.color->width; ++x) {
      (*frame.color)(x, y) = color_of(see(*cameras.color, depth_from_color, x, y));
    }
  }
  return frame;
}

int difference(Rgb8 a, Rgb8 b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

TEST(Registration, HandsRegisteredFramesOnWithoutTouchingThem) {
  const CameraModel camera = depth_camera();
  const SensorCameras cameras{camera, camera, {}, DepthUnit::kMillimetre, true};
  auto registration = Registration::open(cameras).value();
  RgbdFrame frame = photograph(cameras);
  const RgbdFrame copy = frame;
  const void *depth = frame.depth.data(), *color = frame.color->data();
  frame = registration.apply(std::move(frame));
  EXPECT_TRUE(registration.passes_through());
  EXPECT_EQ(frame.depth.data(), depth);
  EXPECT_EQ(frame.color->data(), color);
  EXPECT_EQ(frame.color, copy.color);
  EXPECT_EQ(registration.model(), camera);
}

TEST(Registration, HandsFramesWithoutColorOn) {
  const SensorCameras cameras{depth_camera(), std::nullopt, {}, DepthUnit::kMillimetre, false};
  auto registration = Registration::open(cameras).value();
  const RgbdFrame frame = registration.apply(photograph(cameras));
  EXPECT_TRUE(registration.passes_through());
  EXPECT_FALSE(frame.color.has_value());
}

TEST(Registration, GivesEveryDepthPixelTheColorOfItsPoint) {
  const SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  auto registration = Registration::open(cameras).value();
  const RgbdFrame taken = photograph(cameras);
  const RgbdFrame frame = registration.apply(taken);
  EXPECT_EQ(frame.depth, taken.depth);
  EXPECT_EQ(frame.state, taken.state);
  ASSERT_TRUE(same_shape(*frame.color, frame.depth));
  int wrong = 0;
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (int x = 0; x < frame.depth.width(); ++x) {
      wrong += difference((*frame.color)(x, y), color_of(see(cameras.depth, {}, x, y))) > 12;
    }
  }
  EXPECT_LE(wrong, 2 * (4 * 35));  // two pixels along the board's outline of 4 x 35, where colours mix
}

TEST(Registration, GivesWhatTheColorCameraCannotSeeNoColorOfWhatHidesIt) {
  SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  cameras.color_from_depth.translation.x() = -0.15;  // hides 13 pixels of wall beside the board
  auto registration = Registration::open(cameras).value();
  const RgbdFrame frame = registration.apply(photograph(cameras));
  int red_wall = 0;
  for (int y = 0; y < frame.depth.height(); ++y) {
    for (int x = 0; x < frame.depth.width(); ++x)
      red_wall += frame.depth(x, y) > 2000 && (*frame.color)(x, y).r > 60;
  }
  EXPECT_LE(red_wall, 2 * 35);  // one mixed pixel along each upright edge
}

TEST(Registration, TakesHolesToLieOnTheFartherSurface) {
  const SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  auto registration = Registration::open(cameras).value();
  RgbdFrame frame = photograph(cameras);
  for (int y = 0; y < 120; ++y) {
    for (int x = 98; x < 110; ++x) {  // a shadow right of the board
      frame.depth(x, y) = 0;
      frame.state(x, y) = DepthState::kHole;
    }
  }
  frame = registration.apply(std::move(frame));
  for (int y = 0; y < 120; ++y) {
    for (int x = 100; x < 110; ++x) {
      EXPECT_LE(difference((*frame.color)(x, y), color_of(see(cameras.depth, {}, x, y))), 12)
          << x << ", " << y;
    }
  }
}

TEST(Registration, ScalesColorOfAnotherSizeWhereDepthIsRegistered) {
  CameraModel color = depth_camera();
  color.width *= 2, color.height *= 2, color.fx *= 2, color.fy *= 2;
  color.cx = 2 * color.cx + 0.5, color.cy = 2 * color.cy + 0.5;  // pixel centres lie at whole coordinates
  const SensorCameras cameras{depth_camera(), color, {}, DepthUnit::k100Micrometres, true};
  auto registration = Registration::open(cameras).value();
  RgbdFrame frame = photograph(cameras);
  frame.depth = DepthImage(160, 120);  // not needed for it
  frame.state = StateImage(160, 120, DepthState::kHole);
  frame = registration.apply(std::move(frame));
  ASSERT_TRUE(same_shape(frame.color.value(), frame.depth));
  EXPECT_FALSE(registration.passes_through());
  EXPECT_LE(difference((*frame.color)(20, 30), color_of(see(depth_camera(), {}, 20, 30))), 2);
  EXPECT_LE(difference((*frame.color)(80, 60), {200, 20, 20}), 2);
}

TEST(Registration, LivesWithoutAnyDepth) {
  const SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  auto registration = Registration::open(cameras).value();
  RgbdFrame frame = photograph(cameras);
  frame.depth = DepthImage(160, 120);
  frame.state = StateImage(160, 120, DepthState::kHole);
  EXPECT_TRUE(same_shape(*registration.apply(std::move(frame)).color, DepthImage(160, 120)));
}

TEST(Registration, DropsColorOfASizeNobodyAnnounced) {
  const SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  auto registration = Registration::open(cameras).value();
  RgbdFrame frame = photograph(cameras);
  frame.color = ColorImage(64, 48);
  EXPECT_FALSE(registration.apply(std::move(frame)).color.has_value());
}

TEST(Registration, SurvivesAColorCameraThatLooksElsewhere) {
  SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  for (const double turn : {0.6, 1.6, 3.1}) {
    cameras.color_from_depth.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()).toRotationMatrix();
    auto registration = Registration::open(cameras).value();
    RgbdFrame frame = photograph({depth_camera(), std::nullopt, {}, DepthUnit::kMillimetre, false});
    frame.color = ColorImage(320, 240, {1, 2, 3});
    EXPECT_TRUE(same_shape(*registration.apply(std::move(frame)).color, DepthImage(160, 120)));
  }
}

TEST(Registration, RefusesCamerasThatAreNone) {
  SensorCameras cameras{depth_camera(), wide_color_camera(), beside(), DepthUnit::kMillimetre, false};
  cameras.color_from_depth.rotation *= 2;
  EXPECT_EQ(Registration::open(cameras).error().code, ErrorCode::kInvalid);
  cameras.color_from_depth = beside();
  cameras.color->fx = std::nan("");
  EXPECT_EQ(Registration::open(cameras).error().code, ErrorCode::kInvalid);
  cameras.color = wide_color_camera();
  cameras.depth.width = 0;
  EXPECT_EQ(Registration::open(cameras).error().code, ErrorCode::kInvalid);
}

}  // namespace
}  // namespace copresence::registration
