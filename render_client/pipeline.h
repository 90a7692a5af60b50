#pragma once

// The running client: one thread for each camera, one for matching colours, one that renders. See
// docs/internals/architecture.md.

#include <stop_token>

#include "common/result.h"
#include "render_client/settings.h"

namespace copresence::client {

/// Shows the cameras until a stop is requested, the window is closed, or `settings.frames` views
/// are drawn; all of these are success. Headless it also ends once every camera has ended. Writes
/// statistics and screenshot at the end, also after a failure. Blocks, and makes its own threads. A
/// window requires the main thread.
Result<void> run_pipeline(const ClientSettings& settings, std::stop_source stop);

}  // namespace copresence::client
