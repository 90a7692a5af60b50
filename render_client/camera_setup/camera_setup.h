#pragma once

// The intrinsics, pose and colour correction that the client uses for a camera, and the frames of
// that camera.
//
// Both the stream and the scene file may give these values. They are resolved once per connection,
// so that clipping, colour matching and rendering use the same ones. The scene file wins.
//
// Thread: pure functions and values.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"
#include "common/scene/scene.h"

namespace copresence::client {

struct CameraSetup {
  CameraModel model;  ///< same size as the stream's pictures
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  bool has_pose = false;             ///< the stream or the scene file gives one
  std::optional<Rigid3> fixed_pose;  ///< from the scene file; replaces the poses in the frames
  /// From the scene file; replaces the correction that live matching finds. RGB, 0 to 1.
  std::optional<Eigen::Matrix<float, 3, 4>> color_correction;
  double calibration_error_m = 0.005;
  /// A sentence for the log if the scene file's intrinsics cannot be used; else empty.
  std::string remark;

  /// World from camera for a frame of this stream, metres.
  const Rigid3& pose(const FrameMetadata& metadata) const {
    return fixed_pose ? *fixed_pose : metadata.world_from_camera;
  }
};

/// `scene` may be null. If the scene file's intrinsics are for another picture size, the stream's
/// are used and `remark` says so.
CameraSetup resolve_setup(const StreamDescription& stream, const scene::Scene* scene);

/// A decoded frame that is ready to be displayed, with all that is known of its camera.
struct CameraFrame {
  RgbdFrame frame;
  /// On this process's clock. The time of arrival if the server's times are implausible.
  Instant captured_at;
  Instant arrived_at;                               ///< when the frame became ready to be displayed
  std::shared_ptr<const StreamDescription> stream;  ///< changes with every new connection
  std::shared_ptr<const CameraSetup> setup;         ///< of this stream
  bool times_believed = true;  ///< `captured_at` comes from the server, so it gives the latency

  const Rigid3& pose() const { return setup->pose(frame.metadata); }
};

}  // namespace copresence::client
