#include "render_client/display/window_input.h"

#include <gtest/gtest.h>

namespace copresence::display {
namespace {

using viewpoint::Gesture;

window::MoveEvent pointer_at(double x, double y) {
  window::MoveEvent move{};
  move.x = x;
  move.y = y;
  return move;
}

window::KeyEvent key(window::Key key) {
  window::KeyEvent event{};
  event.key = key;
  event.pressed = true;
  return event;
}

TEST(WindowInput, TranslatesADragByFractionsOfThePicturesHeight) {
  WindowInput input;
  window::MoveEvent left = pointer_at(200, 40), right = pointer_at(200, 80);
  left.left = true;
  right.right = true;
  const auto gestures = input.translate({pointer_at(100, 0), left, right}, 400);
  ASSERT_EQ(gestures.size(), 2U);
  const auto* orbit = std::get_if<viewpoint::Orbit>(&gestures[0]);
  ASSERT_TRUE(orbit);
  EXPECT_DOUBLE_EQ(orbit->right, 0.25);
  EXPECT_DOUBLE_EQ(orbit->down, 0.1);
  const auto* pan = std::get_if<viewpoint::Pan>(&gestures[1]);
  ASSERT_TRUE(pan);
  EXPECT_DOUBLE_EQ(pan->right, 0);
  EXPECT_DOUBLE_EQ(pan->down, 0.1);
}

TEST(WindowInput, RemembersThePointerFromCallToCall) {
  WindowInput input;
  EXPECT_TRUE(input.translate({pointer_at(100, 0)}, 400).empty());
  window::MoveEvent drag = pointer_at(200, 0);
  drag.left = true;
  EXPECT_TRUE(input.translate({drag}, 0).empty()) << "the window is an icon";
  drag.x = 300;
  EXPECT_EQ(input.translate({drag}, 400).size(), 1U);
}

TEST(WindowInput, TranslatesWheelAndKeys) {
  WindowInput input;
  const auto gestures =
      input.translate({window::ScrollEvent{0, 2}, key(window::Key{'R'}), key(window::Key::kHome),
                       key(window::Key{'X'}), key(window::Key::kEscape)},
                      400);
  ASSERT_EQ(gestures.size(), 3U);
  EXPECT_DOUBLE_EQ(std::get<viewpoint::Zoom>(gestures[0]).notches, 2);
  EXPECT_TRUE(std::holds_alternative<viewpoint::ResetPose>(gestures[1]));
  EXPECT_TRUE(std::holds_alternative<viewpoint::ResetPose>(gestures[2]));
}

}  // namespace
}  // namespace copresence::display
