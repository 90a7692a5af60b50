#pragma once

// Opens what --source names.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::sensor {

/// `source` is "openni:" for the first camera, openni:URI, simulated:WORLD?camera=N
/// (drivers/contract/simulated_uri.h), or the path of an .oni recording. A camera may disappear and
/// come back (reconnecting_source.h).
/// Fails  kInvalid (no such simulated camera), and as open_recording() and
///        open_reconnecting_device() do.
Result<std::unique_ptr<FrameSource>> open_source(const std::string& source, const SourceSettings& settings);

/// Whether `source` names a recording. A recording ends and does not come back; a camera may.
bool is_recording(const std::string& source);

}  // namespace copresence::sensor
