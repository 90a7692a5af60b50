#pragma once

// A running capture_server as a source of frames, so that calibration needs no recording: what it sends, with what hole
// filling made up taken out again. Depth and colour have been through its codec; a mean over frames takes most of that
// away.
//
// Thread: as FrameSource.

#include <memory>
#include <string>

#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace copresence::calibrate {

/// address  HOST:PORT. Waits two seconds at most for the server to answer. The description counts as registered, since
///          that is what a server sends; its name is the server's --name.
/// next()   fails with kTimeout where no picture has come for ten seconds, in the server's words of what keeps the camera;
///          they also go to standard error when they come.
/// Fails    as wire::FrameClient::connect(), and kUnsupported for a codec that this program does not have.
Result<std::unique_ptr<sensor::FrameSource>> open_stream(const std::string& address);

}  // namespace copresence::calibrate
