#include "render_client/viewpoint/viewer.h"

#include <gtest/gtest.h>

namespace copresence::client {
namespace {

Rigid3 at(double x_m) {
  Rigid3 pose;
  pose.translation.x() = x_m;
  return pose;
}

// The pointer goes 100 pixels to the right with the left button held, in a window of 400 rows.
std::vector<window::Event> drag() {
  window::MoveEvent begin{}, end{};
  begin.x = 100;
  end.x = 200;
  end.left = true;
  return {begin, end};
}

std::vector<window::Event> press_r() {
  window::KeyEvent key{};
  key.key = window::Key{'R'};
  key.pressed = true;
  return {key};
}

Eye mouse_eye() {
  ClientSettings settings;
  settings.view = "mouse";
  auto eye = Eye::open(settings, nullptr);
  EXPECT_TRUE(eye.has_value());
  return std::move(*eye);
}

Rigid3 pose_of(Eye& eye) {
  return eye.at(0, {}).world_from_eye;
}

TEST(Eye, BeginsAtTheFirstListedCameraThatIsThere) {
  Eye eye = mouse_eye();
  eye.see_camera(2, at(2));
  EXPECT_EQ(pose_of(eye), at(2));
  eye.see_camera(0, at(5));
  EXPECT_EQ(pose_of(eye), at(5)) << "nobody has moved it, so it goes to the camera that is listed first";
  eye.see_camera(1, at(7));
  EXPECT_EQ(pose_of(eye), at(5));
}

TEST(Eye, StaysWhereThePersonMovedItWhenAnEarlierListedCameraAppears) {
  Eye eye = mouse_eye();
  eye.see_camera(1, at(2));
  eye.handle(drag(), 400);
  const Rigid3 moved = pose_of(eye);
  ASSERT_FALSE(moved == at(2));
  eye.see_camera(0, at(5));
  EXPECT_EQ(pose_of(eye), moved);
  eye.handle(press_r(), 400);
  EXPECT_EQ(pose_of(eye), at(5)) << "R goes to the first listed camera";
}

TEST(Eye, GoesToTheFirstCameraEvenIfThePointerWasDraggedOverTheEmptyView) {
  Eye eye = mouse_eye();
  eye.handle(drag(), 400);
  eye.see_camera(0, at(5));
  EXPECT_EQ(pose_of(eye), at(5));
}

}  // namespace
}  // namespace copresence::client
