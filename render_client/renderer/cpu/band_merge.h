#pragma once

// Merges the cameras' fragments of some rows of the view, colours what is left (a texture is read only where
// its camera counts) and softens its outlines. Private to the CPU renderer. Thread: distinct bands may be
// merged side by side.

#include <span>

#include "render_client/renderer/cpu/band.h"
#include "render_client/renderer/cpu/source_texture.h"
#include "render_client/renderer/renderer.h"

namespace copresence::renderer {

/// What the merge has to know of a camera.
struct MergeSource {
  const Texture* texture = nullptr;
  Eigen::Vector4f
      depth;  ///< of the pixel (x, y) at the eye's depth z from the camera: z (x, y, 1).dot(abc) + d
  float calibration_error_m = 0;
  DepthNoise noise;
  int opacity_256 = 256;  ///< CameraView::opacity in 256ths; 256 only of a live camera
};

MergeSource merge_source(const CameraView& camera, const VirtualCamera& eye, const Texture& texture);

/// Merges a band; bands[i] belongs to sources[i], and all lie at the same rows. Images of `view` that
/// `wanted` names have the view's shape.
void merge_band(std::span<const MergeSource> sources, std::span<const Band> bands, HostPixels wanted,
                MergedView& view);

}  // namespace copresence::renderer
