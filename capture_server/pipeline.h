#pragma once

// The running server: who works on which thread and how frames wait between them. See docs/internals/architecture.md.

#include <stop_token>

#include "capture_server/capture_thread.h"
#include "capture_server/heartbeat.h"
#include "capture_server/settings.h"
#include "common/flow/mailbox.h"
#include "common/result.h"
#include "common/wire/listening_socket.h"

namespace copresence::server {

/// Opens the camera and streams it to whoever connects until the recording ends, `settings.frames` were
/// captured or a stop is requested; all of these are success. What comes into `rates` holds from the next
/// frame on. Blocks; makes its own threads, but for `capture`, which opens, reads and closes the source. Each
/// thread that works reports to `heartbeat`.
///
/// A child that replaces one that crashed waits for a camera that is not there, or not usable, and says so in
/// the log.
Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          flow::Mailbox<EncoderSettings>& rates, const std::stop_token& stop,
                          Heartbeat& heartbeat, CaptureThread& capture);

}  // namespace copresence::server
