#pragma once

// Leaves out what lies outside the scene file's [clip] box, camera by camera, before any mesh is made of it.

#include <Eigen/Core>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/scene/scene.h"
#include "render_client/camera_setup.h"

namespace copresence::client {

/// Clips the frames of one camera. The pixels' rays are computed once, here, since the inverse of a lens's
/// distortion takes many times as long as the clipping itself.
///
/// Thread: apply() may run on several threads at once, on different frames.
class Clipper {
 public:
  /// `box` in world metres.
  Clipper(const CameraSetup& setup, const scene::Box& box);

  /// Depth whose point in the world lies outside the box becomes a hole. Requires images of the setup's size.
  void apply(RgbdFrame& frame) const;

 private:
  CameraSetup setup_;
  scene::Box box_;
  std::vector<Eigen::Vector2f> rays_;  // of each pixel, at z = 1
};

}  // namespace copresence::client
