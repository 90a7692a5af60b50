#pragma once

// What --source names, opened: the one place that knows both the recordings' check and the sensors.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence {

/// source  openni: (the first camera), openni:URI, simulated:WORLD?camera=N (drivers/contract/simulated_uri.h), or the
///         path of an .oni recording, which is checked before OpenNI2 sees it. Intrinsics are the recording's own note where it has one, else from its field of view, else a
///         Kinect's. Without a note, colour of depth's size counts as registered to it: nothing else says so in the
///         format, and recorders' default is to register.
///         A camera may go and come back (sensor/lasting_source.h).
/// Fails   kInvalid (a simulated camera that cannot be), and as recording::check(), sensor::open_recording() and sensor::open_device() do.
Result<std::unique_ptr<sensor::FrameSource>> open_source(const std::string& source,
                                                         const sensor::SourceSettings& settings);

/// Whether `source` names a recording, which ends and does not come back, rather than a camera.
bool is_recording(const std::string& source);

}  // namespace copresence
