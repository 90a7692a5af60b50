#pragma once

// The intrinsics, pose and colour correction that the client uses for a camera.
//
// Both the stream and the scene file may state these values. The scene file has priority. The
// values are determined once per connection, so that all parts of the client use the same values.
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
  CameraModel model;  ///< It has the size of the stream's pictures.
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  bool has_pose = false;             ///< Whether the stream or the scene file states a pose.
  std::optional<Rigid3> fixed_pose;  ///< From the scene file. It replaces the poses in the frames.
  /// The scene file's correction, for RGB from 0 to 1. It replaces that of live matching.
  std::optional<Eigen::Matrix<float, 3, 4>> color_correction;
  double calibration_error_m = 0.005;
  /// A sentence for the log if the scene file's intrinsics cannot be used, else empty.
  std::string remark;

  /// Returns the pose world_from_camera for a frame of this stream, in metres.
  const Rigid3& pose(const FrameMetadata& metadata) const {
    return fixed_pose ? *fixed_pose : metadata.world_from_camera;
  }
};

/// Determines the setup. `scene` may be null. If the scene file's intrinsics are for another
/// picture size, the stream's are used and `remark` says so.
CameraSetup resolve_setup(const StreamDescription& stream, const scene::Scene* scene);

/// A decoded frame that is ready to be displayed, with the setup of its camera.
struct CameraFrame {
  RgbdFrame frame;
  /// Capture time on this process's clock, or arrival time if the server's times are implausible.
  Instant captured_at;
  Instant arrived_at;                               ///< Time when the frame was ready for display.
  std::shared_ptr<const StreamDescription> stream;  ///< Changes with every new connection.
  std::shared_ptr<const CameraSetup> setup;         ///< The setup for this stream.
  bool times_believed = true;                       ///< Whether the server's times are plausible.
  /// The surfaces that the camera saw earlier and that something hides in `frame`. Null if there is
  /// no such surface. Successive frames share it while it does not change.
  std::shared_ptr<const RgbdFrame> remembered;

  /// The blocks of the depth image in which a surface moves, as a MotionDetector finds them
  /// (render_client/moving_surfaces).
  Image<std::uint8_t> moving_blocks;

  const Rigid3& pose() const { return setup->pose(frame.metadata); }
};

}  // namespace copresence::client
