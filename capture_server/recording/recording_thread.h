#pragma once

// Records beside the stream, on a thread of its own behind a bounded queue. A slow or full disk costs frames
// of the recording, which are counted and said in the log, and never one of the stream.
//
// Thread: made, used and destroyed by the pipeline; offer() by the capture thread only.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <stop_token>
#include <thread>

#include "capture_server/recording/frame_recording.h"
#include "common/flow/bounded_queue.h"

namespace copresence::server {

class RecordingThread {
 public:
  /// Frames that may wait for the disk: a second's, 50 MB at 640x480.
  static constexpr std::size_t kMostWaiting = 32;

  /// Begins to record. What happens to the recording is said in the log.
  explicit RecordingThread(FrameRecording recording);

  /// Waits until what end() leaves is written, however long the disk takes, and says so in the log. Without
  /// end() no waiting frame is written any more.
  ~RecordingThread();
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;

  /// Copies the frame for the recording, or counts it as left out where there is no room. With `may_wait`,
  /// for sources that can wait, it waits for room, however long the disk takes, and says so in the log.
  void offer(const RgbdFrame& frame, bool may_wait, std::stop_token stop);

  /// Nothing more comes. Of what waits is written what can be within `drain_for`.
  void end(std::chrono::milliseconds drain_for);

  const std::string& path() const { return recording_.path(); }

  /// Frames offered that are not in the recording.
  std::uint64_t left_out() const { return left_out_; }

 private:
  void wait_for_room(const std::stop_token& stop);
  void leave_out();
  void run();
  void write(const RgbdFrame& frame);
  void stop_recording(const Error& error);
  void finish();

  FrameRecording recording_;
  flow::BoundedQueue<RgbdFrame> waiting_{kMostWaiting};
  std::atomic<std::uint64_t> left_out_ = 0;
  std::atomic<Instant> give_up_at_ = Instant::max();
  std::atomic<bool> over_ = false;   ///< no more can be written
  std::uint64_t said_left_out_ = 0;  ///< the capture thread's, as the next
  Instant said_left_out_at_{};
  Instant said_refused_at_{}, checkpoint_at_{};  ///< the recording's thread's
  std::promise<void> written_;
  std::jthread thread_;
};

}  // namespace copresence::server
