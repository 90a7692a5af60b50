#pragma once

// Runs the gateway: one thread for each camera, and one for the web server and its viewers.

#include <stop_token>

#include "common/result.h"
#include "web_gateway/settings.h"

namespace copresence::gateway {

/// Serves until a stop is requested. Fails if it cannot listen, if a file cannot be used, or with
/// kRefused if every camera's server refuses this program for good.
Result<void> run_gateway(const GatewaySettings& settings, std::stop_source stop);

}  // namespace copresence::gateway
