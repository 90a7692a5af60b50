#pragma once

// Records beside the stream: a thread of its own behind a bounded queue. A disk that is too slow or full costs frames
// of the recording, which are counted, and never one of the stream.
//
// Thread: made, used and destroyed by the pipeline; offer() by the capture thread only.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stop_token>
#include <thread>

#include "capture_server/frame_recording.h"
#include "common/flow/in_order.h"

namespace copresence::server {

class RecordingThread {
 public:
  /// Frames that may wait for the disk: a second's, 50 MB at 640x480.
  static constexpr std::size_t kMostWaiting = 32;

  /// Begins to record. What happens to the recording is said in the log.
  explicit RecordingThread(FrameRecording recording);

  /// Waits until what end() leaves is written; ends without a drain where nobody has called it.
  ~RecordingThread();
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;

  /// Copies the frame for the recording, or counts it as left out where there is no room. With `may_wait` it waits
  /// for room instead: for a source that can.
  void offer(const RgbdFrame& frame, bool may_wait, std::stop_token stop);

  /// Nothing more comes. Of what waits is written what can be within `drain_for`.
  void end(std::chrono::milliseconds drain_for);

  /// Frames offered that are not in the recording.
  std::uint64_t left_out() const { return left_out_; }

 private:
  void run();
  void write(const RgbdFrame& frame);
  void stop_recording(const Error& error);
  void finish();

  FrameRecording recording_;
  flow::InOrder<RgbdFrame> waiting_{kMostWaiting};
  std::atomic<std::uint64_t> left_out_ = 0;
  std::atomic<Instant> give_up_at_ = Instant::max();
  std::atomic<bool> over_ = false;  ///< no more can be written
  std::uint64_t said_left_out_ = 0;
  Instant said_at_{}, checkpoint_at_{};
  std::jthread thread_;
};

}  // namespace copresence::server
