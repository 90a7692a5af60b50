#include "render_client/display/window_input.h"

#include "render_client/display/controls.h"

namespace copresence::display {
namespace {

using viewpoint::Gesture;

std::optional<Gesture> drag(const window::MoveEvent& from, const window::MoveEvent& to, int picture_height) {
  const double right = (to.x - from.x) / picture_height, down = (to.y - from.y) / picture_height;
  if (to.left) return viewpoint::Orbit{right, down};
  if (to.right || to.middle) return viewpoint::Pan{right, down};
  return std::nullopt;
}

}  // namespace

std::vector<Gesture> WindowInput::translate(const std::vector<window::Event>& events, int picture_height) {
  std::vector<Gesture> gestures;
  for (const window::Event& event : events) {
    if (const auto* move = std::get_if<window::MoveEvent>(&event)) {
      if (last_move_ && picture_height > 0) {
        if (const auto gesture = drag(*last_move_, *move, picture_height)) gestures.push_back(*gesture);
      }
      last_move_ = *move;
    } else if (const auto* scroll = std::get_if<window::ScrollEvent>(&event)) {
      gestures.emplace_back(viewpoint::Zoom{scroll->y});
    } else if (const auto* key = std::get_if<window::KeyEvent>(&event)) {
      if (command_of(*key) == Command::kResetPose) gestures.emplace_back(viewpoint::ResetPose{});
    }
  }
  return gestures;
}

}  // namespace copresence::display
