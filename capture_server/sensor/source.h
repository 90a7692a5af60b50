#pragma once

// Opens the source of --source.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::sensor {

/// `source` is "openni:" for the first camera, openni:URI, simulated:WORLD?camera=N
/// (drivers/contract/simulated_uri.h), or the path of an .oni recording. A camera may disappear and
/// return (reconnecting_source.h).
/// Fails with kInvalid if there is no such simulated camera, and as open_recording() and
/// open_reconnecting_device() do.
Result<std::unique_ptr<FrameSource>> open_source(const std::string& source, const SourceSettings& settings);

/// True if `source` names a recording. A recording ends and does not return, but a camera may.
bool is_recording(const std::string& source);

}  // namespace copresence::sensor
