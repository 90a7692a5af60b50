#pragma once

// Colours a view by what the merge decided, instead of the cameras' colours. It shows which camera each
// pixel is from (thesis figure 2.8), or how good the pixels are. Thread: pure functions.

#include <cstddef>
#include <span>

#include "common/frame/image.h"
#include "render_client/renderer/renderer.h"

namespace copresence::display {

enum class ViewColors {
  kCameras,  ///< The cameras' own colours.
  kLayers,   ///< A colour for each camera.
  kQuality,  ///< A colour for each quality index.
};

/// Returns the colour of a listed camera. The first eight cameras have different colours.
Rgb8 layer_color(std::size_t camera);

/// Returns the colour of a quality index (merge_rules.h, 1/m^2), on a logarithmic scale. kLeastQuality
/// and less is dark blue, then come green and yellow, and kBestQuality and more is red.
Rgb8 quality_color(float quality);
inline constexpr float kLeastQuality = 0.02F, kBestQuality = 2.0F;

/// Replaces the colours of the view's host pixels, and sets its texture to 0. `cameras` are the numbers
/// of the listed cameras that MergedView::camera refers to. Brightness follows that of the view.
/// Remembered pixels are darker. Pixels that no camera has seen become gray (kLayers) or black
/// (kQuality). Requires colour and depth as host pixels. Does nothing for kCameras.
void recolor(ViewColors colors, std::span<const std::size_t> cameras, renderer::MergedView& view);

}  // namespace copresence::display
