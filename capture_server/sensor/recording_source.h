#pragma once

// An .oni recording as a frame source. Pictures are decoded one frame ahead, so that a frame is
// ready when it is due. Damaged pictures are counted and skipped; all others are exact.
// Thread: as FrameSource.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::sensor {

/// Opens the recording at `path`. Fails as recording::check() and recording::check_playable() do.
Result<std::unique_ptr<FrameSource>> open_recording(const std::string& path, const SourceSettings& settings);

}  // namespace copresence::sensor
