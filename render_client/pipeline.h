#pragma once

// Runs the client. It uses one thread for each camera, one for matching colours and one for
// rendering. See docs/internals/architecture.md.

#include <stop_token>

#include "common/result.h"
#include "render_client/settings.h"

namespace copresence::client {

/// Shows the cameras until a stop is requested, the window is closed, or `settings.frames` views
/// are drawn. A headless client also ends once every camera has ended. In all these cases, the
/// function succeeds. At the end, even after a failure, it writes statistics and screenshot. The
/// function blocks, and makes its own threads. A window requires the main thread.
Result<void> run_pipeline(const ClientSettings& settings, std::stop_source stop);

}  // namespace copresence::client
