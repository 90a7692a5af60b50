#pragma once

// The panels of the overlay. Each function draws one panel and returns its area. Call the functions between
// ImGui::NewFrame() and ImGui::Render(). `size` is that of the picture in pixels. Thread: that of Dear
// ImGui's context.

#include <imgui.h>

#include <vector>

#include "render_client/display/overlay/overlay.h"

namespace copresence::overlay {

struct Area {
  ImVec2 min, max;  ///< Pixels.

  bool contains(ImVec2 point) const {
    return point.x >= min.x && point.x < max.x && point.y >= min.y && point.y < max.y;
  }
};

/// At the bottom: why cameras are not shown, and the message.
Area draw_notices(const Content& content, ImVec2 size);

/// At the top right.
Area draw_keys(const std::vector<Row>& keys, ImVec2 size);

/// At the top left: the figures and the switches. Appends its area, that of a tooltip, if there is one,
/// and the switches that are clicked.
void draw_figures(const Content& content, std::vector<Area>& panels, std::vector<int>& clicks);

}  // namespace copresence::overlay
