#pragma once

// The settings of the view that the user changes while it runs, by keys or by the switches of the
// overlay. Thread: the render thread.

#include <vector>

#include "render_client/display/controls.h"
#include "render_client/display/overlay/overlay.h"
#include "render_client/display/view_colors.h"
#include "render_client/renderer/renderer.h"

namespace copresence::client {

struct ViewOptions {
  renderer::MergeMode merge = renderer::MergeMode::kBlend;
  renderer::UnseenStyle unseen;
  bool corrects_colors = true;  ///< Whether the cameras' colours are corrected.
  display::ViewColors colors = display::ViewColors::kCameras;

  bool can_draw_wireframe = false;  ///< Whether the renderer can.
  bool wireframe = false;

  /// Returns how unseen pixels look. They stay black between the lines of a wireframe.
  renderer::UnseenStyle shown_unseen() const;

  /// Carries out a command. Returns whether it changes the view.
  bool apply(display::Command command);

  /// Returns the switches of the overlay. The id of a switch is its command.
  std::vector<overlay::Switch> switches() const;
};

}  // namespace copresence::client
