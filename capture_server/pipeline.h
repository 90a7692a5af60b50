#pragma once

// The running server: the stages, their threads and the queues between them. See
// docs/internals/architecture.md.

#include <stop_token>

#include "capture_server/capture_thread.h"
#include "capture_server/settings.h"
#include "capture_server/supervisor/heartbeat.h"
#include "common/flow/mailbox.h"
#include "common/result.h"
#include "common/wire/listening_socket.h"

namespace copresence::server {

/// Opens the source and streams it to all clients until the recording ends, `settings.frames` were
/// captured or a stop is requested; all of these are success. New settings in `encoder_changes`
/// take effect at the next frame. Blocks. It creates its own threads, except `capture`, which
/// opens, reads and closes the source. Each working thread reports to `heartbeat`.
Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          flow::Mailbox<EncoderSettings>& encoder_changes, const std::stop_token& stop,
                          Heartbeat& heartbeat, CaptureThread& capture);

}  // namespace copresence::server
