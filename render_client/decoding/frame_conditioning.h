#pragma once

// What the client does to a decoded frame before it becomes a surface.
//
// Thread: one thread at a time per object.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/scene/scene.h"
#include "render_client/camera_setup/camera_setup.h"
#include "render_client/decoding/depth_smoothing.h"
#include "render_client/decoding/temporal_filter.h"

namespace copresence::decoding {

/// Removes depth outside the scene file's [clip] box from the frames of one camera. The pixels'
/// rays are computed once: inverting a lens distortion takes many times as long as the clipping
/// itself.
class Clipper {
 public:
  /// `box` in world metres.
  Clipper(const client::CameraSetup& setup, const scene::Box& box);

  /// Depth whose point in the world lies outside the box becomes a hole. Requires images of the
  /// setup's size.
  void apply(RgbdFrame& frame) const;

 private:
  client::CameraSetup setup_;
  scene::Box box_;
  std::vector<Eigen::Vector2f> rays_;  // by pixel, at z = 1
};

/// Filters the frames of one camera over time, clips them and smooths their depth, in this order.
class FrameConditioner {
 public:
  /// Call it for every new connection, before the first frame. The temporal filter goes on: it
  /// detects by itself that the picture has changed. `clip` in world metres.
  void begin(const client::CameraSetup& setup, const std::optional<scene::Box>& clip);

  /// Requires begin().
  void apply(RgbdFrame& frame);

 private:
  DepthUnit unit_ = DepthUnit::kMillimetre;
  DepthNoise noise_;
  TemporalFilter temporal_filter_;
  std::optional<Clipper> clipper_;
  DepthSmoothing smoothing_;
};

}  // namespace copresence::decoding
