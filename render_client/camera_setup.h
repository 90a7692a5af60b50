#pragma once

// What the client uses as a camera's intrinsics, pose and colour correction. The stream and the scene file
// may both say so; they are resolved once per connection, so that clipping, colour matching and rendering use
// the same values.
//
// Where both say something, the scene file wins.
// Thread: pure functions and values.

#include <cstdint>
#include <optional>
#include <string>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/frame/stream_description.h"
#include "common/scene/scene.h"
#include "render_client/color_matching/color_correction.h"
#include "render_client/color_matching/color_pairs.h"
#include "render_client/renderer/renderer.h"

namespace copresence::client {

struct CameraSetup {
  CameraModel model;  ///< same size as the stream's pictures
  DepthUnit unit = DepthUnit::kMillimetre;
  DepthNoise noise;
  bool has_pose = false;             ///< the stream or the scene file gives one
  std::optional<Rigid3> fixed_pose;  ///< the scene file's; beats the poses in the frames
  std::optional<color_matching::ColorCorrection>
      color_matching;  ///< the scene file's; beats what is found live
  double calibration_error_m = renderer::CameraView{}.calibration_error_m;
  /// A sentence for the log where the scene file's intrinsics cannot be used; else empty.
  std::string remark;

  /// World from camera of a frame of this stream, metres.
  const Rigid3& pose(const FrameMetadata& metadata) const {
    return fixed_pose ? *fixed_pose : metadata.world_from_camera;
  }
};

/// `scene` may be null. Intrinsics of another picture size than the stream's are not used; `remark` says so
/// then.
CameraSetup resolve_setup(const StreamDescription& stream, const scene::Scene* scene);

/// A frame of this camera as a renderer takes it. `version` as in CameraView. `found` is the colour
/// correction that live matching has found. `frame` must outlive the result's use.
renderer::CameraView camera_view(const CameraSetup& setup, const RgbdFrame& frame, std::uint64_t version,
                                 const color_matching::ColorCorrection& found);

/// The same as colour matching takes it.
color_matching::PosedFrame posed_frame(const CameraSetup& setup, const RgbdFrame& frame);

}  // namespace copresence::client
