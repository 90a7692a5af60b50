#pragma once

// The running client: one thread for each camera, one that renders. See docs/internals/architecture.md.

#include <stop_token>

#include "common/result.h"
#include "render_client/settings.h"

namespace copresence::client {

/// Shows the cameras until a stop is requested, the window is closed or `settings.frames` views were
/// rendered; all of these are success. Writes statistics and screenshot at the end, also after a failure.
/// Blocks; makes its own threads. Requires the main thread where there is a window.
Result<void> run_pipeline(const ClientSettings& settings, std::stop_source stop);

}  // namespace copresence::client
