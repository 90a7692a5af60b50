#pragma once

// The running server: its stages, threads and queues (docs/internals/architecture.md).

#include <stop_token>

#include "capture_server/capture_thread.h"
#include "capture_server/settings.h"
#include "capture_server/supervisor/heartbeat.h"
#include "common/flow/mailbox.h"
#include "common/result.h"
#include "common/tls/room_key.h"
#include "common/wire/listening_socket.h"

namespace copresence::server {

/// Opens the source and streams it to all clients. The function succeeds when the recording ends,
/// when `settings.frames` frames are captured, or when a stop is requested. New settings in
/// `encoder_changes` take effect at the next frame. `key` encrypts the stream and may be null.
///
/// Thread: blocks the calling thread. `capture` opens, reads and closes the source; the function
/// creates all other threads. Each working thread reports to `heartbeat`.
Result<void> run_pipeline(const ServerSettings& settings, const wire::ListeningSocket& listening,
                          const tls::RoomKey* key, flow::Mailbox<EncoderSettings>& encoder_changes,
                          const std::stop_token& stop, Heartbeat& heartbeat, CaptureThread& capture);

}  // namespace copresence::server
