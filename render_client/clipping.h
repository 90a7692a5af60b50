#pragma once

// Leaves out what lies outside the scene file's [clip] box, camera by camera, before any mesh is made of it.
// Thread: pure.

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/scene/scene.h"

namespace copresence::client {

/// Depth whose point in the world lies outside `box` becomes a hole. Requires camera's size to be the
/// frame's.
void clip(RgbdFrame& frame, const CameraModel& camera, DepthUnit unit, const Rigid3& world_from_camera,
          const scene::Box& box);

}  // namespace copresence::client
