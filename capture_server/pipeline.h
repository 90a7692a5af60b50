#pragma once

// The running server: who works on which thread and how frames wait between them. See docs/architecture.md.

#include <functional>
#include <memory>
#include <stop_token>

#include "capture_server/settings.h"
#include "common/flow/latest.h"
#include "common/result.h"
#include "common/wire/listening_socket.h"

namespace copresence::server {

/// Opens the camera and streams it to whoever connects until the recording ends, `settings.frames` were
/// captured or a stop is requested; all of these are success. What comes into `rates` holds from the next frame on.
/// `alive` is called at least every second while the capture works, every four where it gets no core. Blocks; makes its
/// own threads.
Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          flow::Latest<Rates>& rates, const std::stop_token& stop,
                          const std::function<void()>& alive);

}  // namespace copresence::server
