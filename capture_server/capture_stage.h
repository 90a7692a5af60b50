#pragma once

// The first stage of the pipeline, on the capture thread. It opens the source, reads its frames,
// records them and passes them to the encode stage.
// Thread: all work runs on the capture thread. Any other thread may call the functions.

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

/// Encoding and the decoding of recordings add this number to their threads' nice value. So a
/// render_client on the same machine does not stutter. This costs at most one frame period of
/// latency.
inline constexpr int kStepsBelowRendering = 5;

/// A frame on its way to the encode stage, with the source's counters at the time of its capture.
struct CapturedFrame {
  RgbdFrame frame;
  sensor::SourceCounters pictures;
};

/// The time that --start-at gives, converted to the steady clock. Nothing without --start-at.
std::optional<Instant> first_frame_due(const ServerSettings& settings);

/// Opens the source on the capture thread. After a crash of the previous child process, the camera
/// may be missing or still held by its driver. The function waits for the camera and logs that.
/// Fails as sensor::open_source() does, and with kEndOfStream on a stop request.
Result<std::unique_ptr<sensor::FrameSource>> open_source(const ServerSettings& settings,
                                                         std::optional<Instant> begin,
                                                         const std::stop_token& stop, Heartbeat& heartbeat,
                                                         CaptureThread& capture);

/// Closes the source on the thread that opened it.
void close_source(CaptureThread& capture, std::unique_ptr<sensor::FrameSource> source, Heartbeat& heartbeat);

class CaptureStage {
 public:
  /// `recording` may be null. All arguments outlive this object.
  CaptureStage(const ServerSettings& settings, std::optional<Instant> begin, sensor::FrameSource& source,
               RecordingThread* recording, wire::FrameServer& server, Heartbeat& heartbeat);

  /// Puts frames into `captured` until the source ends, a stop is requested, or as many frames as
  /// --frames asks for are captured.
  Result<void> run(flow::Mailbox<CapturedFrame>& captured, const std::stop_token& stop, Pulse& pulse);

  /// True if run() captured as many frames as --frames asks for.
  bool has_all_frames() const { return has_all_frames_; }

  /// Logs how many pictures run() received without making them part of a frame, and why.
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
  std::optional<ErrorCode> interrupted_by_;  ///< The error that interrupts the frames at present.
  bool damage_is_logged_ = false, has_begun_ = false, has_all_frames_ = false;
};

}  // namespace copresence::server
