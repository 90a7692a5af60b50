#pragma once

// Finds points that two cameras see, and their colours in both images. The measured surface of one
// camera is projected into the image of the other camera. The thesis (2.6.1 and 2.6.2) finds such
// points by drawing a view. Thread: pure functions.

#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "render_client/color_matching/color_fit.h"

namespace copresence::color_matching {

/// A camera's frame with its pose. Requires colour, and images of the model's size.
struct PosedFrame {
  const RgbdFrame* frame = nullptr;
  CameraModel model;
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  Rigid3 world_from_camera;
  double calibration_error_m = 0.005;  ///< It widens the tolerance for equal depth.
};

/// Returns pairs from every `spacing_px`-th pixel of `from` (>= 1). Each colour is the mean over 3
/// x 3 pixels with measured depth. Colours near black or white are skipped, because they may be
/// clipped. Colours that vary within the 3 x 3 pixels are skipped, because a misalignment would
/// change them. Points are skipped if their depth in both images differs by more than 3 sigma of
/// both sensors plus both calibration errors.
std::vector<ColorPair> find_color_pairs(const PosedFrame& from, const PosedFrame& to, int spacing_px);

}  // namespace copresence::color_matching
