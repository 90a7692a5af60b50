#pragma once

// Merges the fragments of all cameras in a tile of the view, and softens silhouette edges. A
// camera's texture is sampled only at pixels where the camera's fragment has a weight above 0.
// Thread: different tiles may be merged at the same time.

#include <cstddef>
#include <span>

#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/silhouettes.h"
#include "render_client/renderer/cpu/tile.h"
#include "render_client/renderer/merge_rules.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// One camera as input of the merge.
struct MergeCamera {
  const CameraTexture* texture = nullptr;
  /// Coefficients (a, b, c, d). A fragment at pixel (x, y) with depth z along the eye's axis has
  /// the depth z (a x + b y + c) + d along the camera's axis.
  Eigen::Vector4f depth;
  float calibration_error_m = 0;
  DepthNoise noise;
  int opacity_256 = 256;  ///< 256 times the brightness of the camera's colours.
  Rank rank = Rank::kLive;
  int index = 0;  ///< The camera's value in MergedView::camera.
};

/// Returns a MergeCamera without its index. `brightness` is that of remembered surfaces, 0 to 1.
MergeCamera merge_camera(const CameraView& camera, const ViewPose& eye, const CameraTexture& texture,
                         float brightness);

struct MergeSettings {
  HostPixels wanted;
  Rgb8 background;  ///< Colour of pixels without a fragment. Their alpha is 0.
  /// Minimum difference between inverse depths at a silhouette edge, 1/m.
  float silhouette_step = 0;
  MergeMode mode = MergeMode::kBlend;
};

/// Merges a tile. tiles[i] belongs to cameras[i]. `inverse` gets the inverse depths of the nearest
/// fragments along the eye's axis, 1/m, or 0 where there is no fragment. It may be empty if they
/// are not needed. If colours are wanted, `borders` gets the tile's first and last row, and the
/// function returns the number of pixels that show a fragment, else 0. Requires tiles of the same
/// rows. Requires that `inverse` and the wanted images of `view` have the view's size.
std::size_t merge_tile(std::span<const MergeCamera> cameras, std::span<const Tile> tiles,
                       const MergeSettings& settings, MergedView& view, Image<float>& inverse,
                       TileBorders& borders);

}  // namespace copresence::renderer
