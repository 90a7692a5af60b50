#pragma once

// The first stage of the pipeline: opens the source, reads its frames, records them and passes them
// to the encode stage.
//
// Thread: everything runs on the capture thread, but the functions may be called from any other.

#include <memory>
#include <optional>
#include <stop_token>

#include "capture_server/capture_thread.h"
#include "capture_server/recorder/recording_thread.h"
#include "capture_server/sensor/frame_source.h"
#include "capture_server/settings.h"
#include "capture_server/supervisor/heartbeat.h"
#include "common/flow/mailbox.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "common/wire/frame_server.h"

namespace copresence::server {

/// Encoding and the decoding of recordings run at this many steps of nice, so that a render_client
/// on the same machine does not stutter. One frame more of latency is the better choice.
inline constexpr int kStepsBelowRendering = 5;

/// A frame on its way to the encode stage, with the source's counters at the time of its capture.
struct CapturedFrame {
  RgbdFrame frame;
  sensor::SourceCounters pictures;
};

/// The instant of --start-at on the steady clock.
std::optional<Instant> first_frame_due(const ServerSettings& settings);

/// Opens the source on the capture thread. After a crash of the child before this one it waits for
/// a camera that is missing or still held by its driver, and says so in the log.
/// Fails  as sensor::open_source(), and with kEndOfStream on a stop request.
Result<std::unique_ptr<sensor::FrameSource>> open_source(const ServerSettings& settings,
                                                         std::optional<Instant> begin,
                                                         const std::stop_token& stop, Heartbeat& heartbeat,
                                                         CaptureThread& capture);

/// Closes the source on the thread that opened it.
void close_source(CaptureThread& capture, std::unique_ptr<sensor::FrameSource> source, Heartbeat& heartbeat);

class CaptureStage {
 public:
  /// `recording` may be null. Everything outlives this.
  CaptureStage(const ServerSettings& settings, std::optional<Instant> begin, sensor::FrameSource& source,
               RecordingThread* recording, wire::FrameServer& server, Heartbeat& heartbeat);

  /// Puts frames into `captured` until the source ends, --frames are captured or a stop is
  /// requested.
  Result<void> run(flow::Mailbox<CapturedFrame>& captured, const std::stop_token& stop, Pulse& pulse);

  /// After run(): whether --frames were captured.
  bool has_all_frames() const { return has_all_frames_; }

  /// After run(): writes to the log how many pictures are in no frame, and why.
  void log_missing_pictures() const;

 private:
  bool may_open_again() const;
  void wait_for_begin(const std::stop_token& stop, Pulse& pulse) const;
  bool may_continue(const Error& error) const;
  void log_interruption(const Error& why);
  void log_resumption();

  const ServerSettings& settings_;
  const std::optional<Instant> begin_;
  sensor::FrameSource& source_;
  RecordingThread* const recording_;
  wire::FrameServer& server_;
  Heartbeat& heartbeat_;
  std::optional<ErrorCode> interrupted_by_;  ///< while no frames come: the reason
  bool damage_is_logged_ = false, has_begun_ = false, has_all_frames_ = false;
};

}  // namespace copresence::server
