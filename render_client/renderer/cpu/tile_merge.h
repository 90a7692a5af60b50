#pragma once

// Merges the fragments of all cameras in a tile of the view, and softens silhouette edges. A
// camera's texture is read only where the camera counts.
//
// Thread: distinct tiles may be merged at the same time.

#include <span>

#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/tile.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// A camera as the merge takes it.
struct MergeCamera {
  const CameraTexture* texture = nullptr;
  Eigen::Vector4f
      /// Depth along the camera's axis of pixel (x, y) at the eye's depth z: z (x, y, 1).dot(abc) +
      /// d.
      depth;
  float calibration_error_m = 0;
  DepthNoise noise;
  int opacity_256 = 256;  ///< CameraView::opacity in 256ths; below 256 for a stale camera
};

MergeCamera merge_camera(const CameraView& camera, const ViewPose& eye, const CameraTexture& texture);

/// Merges a tile. tiles[i] belongs to cameras[i], and all have the same rows. The images of `view`
/// that are `wanted` have the view's size. `inverse` gets the inverse depth of the nearest fragments, 1/m along the eye's
/// axis, 0 without any; it has the view's size, or none if it is not wanted.
void merge_tile(std::span<const MergeCamera> cameras, std::span<const Tile> tiles, HostPixels wanted,
                MergedView& view, Image<float>& inverse);

}  // namespace copresence::renderer
