#pragma once

// Translates what a person does in a window into gestures.
//
// Thread: one at a time.

#include <optional>
#include <vector>

#include "common/window/event.h"
#include "render_client/viewpoint/viewpoint.h"

namespace copresence::display {

class WindowInput {
 public:
  /// Dragging with the left button orbits, with the right or middle button it pans. The wheel
  /// zooms. R and Home reset the pose. `picture_height` of the window, pixels.
  std::vector<viewpoint::Gesture> translate(const std::vector<window::Event>& events, int picture_height);

 private:
  std::optional<window::MoveEvent> last_move_;
};

}  // namespace copresence::display
