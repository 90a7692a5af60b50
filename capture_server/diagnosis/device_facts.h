#pragma once

// What an open camera says of itself, as this project's types. Only for this room's own sources.
//
// Thread: as the device's owner.

#include <OpenNI.h>

#include <optional>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"

namespace copresence::sensor {

/// Whether a mode's pictures can become frames: depth in 1 mm or 0.1 mm, colour in RGB888, of even size.
bool is_usable(const openni::VideoMode& mode, bool is_depth);

/// The usable mode that is nearest to the size wanted, then to 30 a second, then in 1 mm before 0.1 mm.
std::optional<openni::VideoMode> choose_mode(const openni::SensorInfo& sensor, bool is_depth, int width,
                                             int height);

/// From its own intrinsics, else its field of view, else a Kinect's.
CameraModel camera_of(const openni::VideoStream& stream);

/// Where the camera stands, if it knows: world_from_camera.
std::optional<Rigid3> pose_of(const openni::Device& device);

}  // namespace copresence::sensor
