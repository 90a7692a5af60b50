#pragma once

// The second stage of the pipeline: encodes captured frames and hands them to the wire.
//
// Thread: run() on the thread that opened the encoding, since a graphics context may belong to it.

#include <cstdint>
#include <optional>

#include "capture_server/capture_stage.h"
#include "capture_server/encoding/frame_encoding.h"
#include "capture_server/settings.h"
#include "capture_server/supervisor/heartbeat.h"
#include "common/flow/mailbox.h"
#include "common/result.h"
#include "common/wire/frame_server.h"

namespace copresence::server {

class EncodeStage {
 public:
  /// `changes` has encoder settings that take effect at the next frame. Everything outlives this.
  EncodeStage(const ServerSettings& settings, FrameEncoding& encoding, wire::FrameServer& server,
              flow::Mailbox<EncoderSettings>& changes)
      : settings_(settings),
        encoding_(encoding),
        server_(server),
        changes_(changes),
        current_(settings.encoder) {}

  /// Encodes until `captured` is closed and empty. Fails if no later frame can be encoded either.
  Result<void> run(flow::Mailbox<CapturedFrame>& captured, Pulse pulse);

 private:
  Result<void> encode(CapturedFrame captured, Executor& workers);
  void change(const EncoderSettings& settings);

  const ServerSettings& settings_;
  FrameEncoding& encoding_;
  wire::FrameServer& server_;
  flow::Mailbox<EncoderSettings>& changes_;
  EncoderSettings current_;
  std::optional<EncoderSettings> previous_;  ///< before the last change, to go back to if encoding fails
  bool keyframe_owed_ = false;               ///< a frame that was to be a keyframe failed
  std::uint64_t without_room_ = 0;           ///< frames dropped because no viewer was there or had room
  std::uint64_t encoder_busy_ = 0;           ///< frames replaced by newer ones, dropped as stale, or failed
};

/// "qp 20" or "4000 kbit/s".
std::string depth_quality(const EncoderSettings& settings);

}  // namespace copresence::server
