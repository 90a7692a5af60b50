#pragma once

// Translates mouse and key events of a window into gestures. Thread: one thread at a time per
// object.

#include <optional>
#include <vector>

#include "common/window/event.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::display {

class WindowInput {
 public:
  /// Dragging with the left button orbits. Dragging with the right or middle button pans. The wheel
  /// zooms. Command::kResetPose resets the pose. `picture_height` is the window's height in pixels.
  std::vector<viewpoint::Gesture> translate(const std::vector<window::Event>& events, int picture_height);

 private:
  std::optional<window::MoveEvent> last_move_;
};

}  // namespace copresence::display
