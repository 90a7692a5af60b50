#pragma once

// The second stage of the pipeline, between capture and network. The stage encodes captured frames
// and passes them to the frame server.
// Thread: call run() on the thread that opened the encoding, which may own a graphics context.

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
  /// `changes` holds settings for the next frame. All arguments outlive this object.
  EncodeStage(const ServerSettings& settings, FrameEncoding& encoding, wire::FrameServer& server,
              flow::Mailbox<EncoderSettings>& changes)
      : settings_(settings),
        encoding_(encoding),
        server_(server),
        changes_(changes),
        current_(settings.encoder) {}

  /// Encodes until `captured` is closed and empty. Fails only if all later frames would fail.
  Result<void> run(flow::Mailbox<CapturedFrame>& captured, Pulse pulse);

 private:
  Result<void> encode(CapturedFrame captured, Executor& workers);
  void change(const EncoderSettings& settings);

  const ServerSettings& settings_;
  FrameEncoding& encoding_;
  wire::FrameServer& server_;
  flow::Mailbox<EncoderSettings>& changes_;
  EncoderSettings current_;
  std::optional<EncoderSettings> previous_;  ///< The settings before the last change.
  bool keyframe_owed_ = false;               ///< The next frame must be a keyframe.
  std::uint64_t without_room_ = 0;           ///< Frames dropped because no viewer could take them.
  std::uint64_t encoder_busy_ = 0;  ///< Frames that were replaced by newer ones, dropped as stale, or failed.
};

/// Returns a text such as "qp 20" or "4000 kbit/s".
std::string depth_quality(const EncoderSettings& settings);

}  // namespace copresence::server
