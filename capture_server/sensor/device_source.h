#pragma once

// Cameras as frame sources, through OpenNI2.
// Thread: as FrameSource.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::sensor {

/// Opens a camera. `uri` is a URI that capture_server --list shows after "openni:", or empty for
/// the first camera found. The modes are depth at 640x480 and 30 frames a second, or the nearest
/// mode, and RGB888 of the same size. Depth is registered to colour and both are exposed at once,
/// if the device can do so.
/// Fails with kNotFound if there is no such camera. Fails with kUnavailable if another program
/// holds it or a permission is missing. Fails with kUnsupported without depth, without a requested
/// control, or if OpenNI2 does not start.
Result<std::unique_ptr<FrameSource>> open_device(const std::string& uri, const CameraControls& controls = {});

/// Opens a camera that may be unplugged and plugged in again (reconnecting_source.h). With an empty
/// `uri` the source always waits for the camera that it opened first.
Result<std::unique_ptr<FrameSource>> open_reconnecting_device(const std::string& uri,
                                                              const CameraControls& controls = {});

}  // namespace copresence::sensor
