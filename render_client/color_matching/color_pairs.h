#pragma once

// Places that two cameras see, found by their depth: each camera's measured surface is looked up in the other's image
// (the overlapping fragments of thesis 2.6.1 and 2.6.2, without a view to draw them in). Thread: pure.

#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "render_client/color_matching/color_correction.h"

namespace copresence::color_matching {

/// A camera's frame and where it stands. Requires colour; images of the model's size.
struct PosedFrame {
  const RgbdFrame* frame = nullptr;
  CameraModel model;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  Rigid3 world_from_camera;
  double calibration_error_m = 0.005;  ///< widens what counts as the same depth
};

/// Pairs from every `spacing_px`-th pixel of `from` (>= 1), each the mean over 3 x 3 pixels of measured depth. Left
/// out: colours near either end of what a camera can tell apart, since they are cut off there; places whose colour
/// changes across the mean, since a pixel of misalignment would change it; and surfaces that `to` sees behind or before
/// them by more than 3 sigma of both sensors and both calibrations.
std::vector<ColorPair> find_color_pairs(const PosedFrame& from, const PosedFrame& to, int spacing_px);

}  // namespace copresence::color_matching
