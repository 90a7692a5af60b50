#pragma once

// Prepares a decoded frame for rendering: separates colours at silhouettes, clips and smooths
// depth. Thread: one thread at a time.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/scene/scene.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/decoding/silhouette_colors.h"

namespace copresence::decoding {

/// Removes depth outside the scene file's [clip] box from the frames of one camera. The rays of the
/// pixels are computed only once: inverting the lens distortion takes far longer than clipping.
class Clipper {
 public:
  /// `box` has world coordinates in metres.
  Clipper(const client::CameraSetup& setup, const scene::Box& box);

  /// Turns pixels outside the box into holes. Requires images of the setup's size.
  void apply(RgbdFrame& frame) const;

 private:
  client::CameraSetup setup_;
  scene::Box box_;
  std::vector<Eigen::Vector2f> rays_;  // The ray (x, y) at z = 1 of every pixel.
};

/// Separates the colours at silhouettes in the frames of one camera, clips depth and smooths it.
/// The server has already filtered the frames over time.
class FrameConditioner {
 public:
  /// Call it for every new connection, before the first frame. `clip` has world coordinates in
  /// metres.
  void begin(const client::CameraSetup& setup, const std::optional<scene::Box>& clip);

  /// Requires begin().
  void apply(RgbdFrame& frame);

 private:
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
  SilhouetteColors silhouette_colors_;
  std::optional<Clipper> clipper_;
  DepthSmoothing smoothing_;
};

}  // namespace copresence::decoding
