#pragma once

// The one interface of both renderers: the cameras' newest frames and a viewpoint in, a merged view out.
//
// Each camera's depth becomes a mesh without triangles across discontinuities, is drawn from the eye, and the
// drawings are merged in window space: of the fragments within the uncertainty range of the nearest one the
// best quality index wins (thesis 2.6.1). Both implementations follow the same rules
// (renderer/merge_rules.h), and a test holds their pictures together.
//
// Thread: one thread makes, uses and destroys a renderer.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "render_client/renderer/merged_view.h"

namespace copresence::renderer {

/// The most cameras that one view can show, in both renderers. Command line and scene file are checked.
inline constexpr std::size_t kMostCameras = 32;

/// One camera as a renderer sees it.
struct CameraView {
  const RgbdFrame* frame =
      nullptr;  ///< its newest; must outlive the call. Poses come from `world_from_camera` below
  /// Cache key: the renderer reuses a slot's mesh and texture while `version` is unchanged. So every frame,
  /// of any camera, must have a version of its own.
  std::uint64_t version = 0;
  CameraModel model;  ///< same size as the frame's images
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  Rigid3 world_from_camera;
  Eigen::Matrix<float, 3, 4> color_matching =
      Eigen::Matrix<float, 3, 4>::Identity();  ///< to the reference camera's colours, RGB 0 to 1
  double calibration_error_m = 0.005;          ///< widens the uncertainty range
  /// 1 for a live camera. Below 1 it fades since no new frame has come (merge_rules.h, Stale). 0: not drawn.
  float opacity = 1;
};

class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual std::string_view name() const = 0;  ///< "cpu" or "gl", as in --renderer and the statistics

  /// Makes meshes and textures of these cameras ahead, which need no eye. Call it while no view is due yet.
  /// The next render() may be given newer frames or other cameras all the same.
  virtual void prepare(std::span<const CameraView> cameras) = 0;

  /// Draws the cameras in order (the index is what MergedView::camera names) as seen from `eye`. Cameras may
  /// be fewer than before or have new models. `view` is reused: images keep their memory. A camera without
  /// colour is shaded by its normals. Requires at most kMostCameras. Fails only where the graphics driver
  /// does.
  virtual Result<void> render(std::span<const CameraView> cameras, const VirtualCamera& eye,
                              HostPixels wanted, MergedView& view) = 0;
};

}  // namespace copresence::renderer
