#pragma once

// Cameras as frame sources, by OpenNI2.
//
// Thread: as FrameSource.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::sensor {

/// Opens a camera. `uri` as in capture_server --list after "openni:"; empty for the first camera
/// found. Chosen are depth at 640x480 and 30 frames a second or the nearest mode, and RGB888 of the
/// same size if there is colour. If the device can, depth is registered to colour and both are
/// exposed at once.
/// Fails  kNotFound (no such camera), kUnavailable (held by another program, no permission),
///        kUnsupported (no depth, controls that the camera does not offer, or OpenNI2 does not
///        start).
Result<std::unique_ptr<FrameSource>> open_device(const std::string& uri, const CameraControls& controls = {});

/// The same for a camera that may be unplugged and plugged in again: see reconnecting_source.h.
/// With an empty `uri` it waits for the camera that it opened first, not for another one.
Result<std::unique_ptr<FrameSource>> open_reconnecting_device(const std::string& uri,
                                                              const CameraControls& controls = {});

}  // namespace copresence::sensor
