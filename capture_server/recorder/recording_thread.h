#pragma once

// Records in parallel to the stream, on a thread of its own with a bounded queue. If the disk is
// slow or full, the recording loses frames, which are counted and logged. The stream never does.
//
// Thread: created, used and destroyed by the pipeline; offer() only by the capture thread.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <stop_token>
#include <thread>

#include "capture_server/recorder/frame_recording.h"
#include "common/flow/bounded_queue.h"

namespace copresence::server {

class RecordingThread {
 public:
  /// Frames that may wait for the disk: one second, 50 MB at 640x480.
  static constexpr std::size_t kMostWaiting = 32;

  /// Begins to record. The recording's progress is logged.
  explicit RecordingThread(FrameRecording recording);

  /// Waits until the frames that end() left are written, however long the disk takes, and logs that
  /// it waits. Without end(), frames in the queue are dropped.
  ~RecordingThread();
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;

  /// Copies the frame into the queue, or counts it as left out if the queue is full. With
  /// `may_wait`, for sources that can wait, it waits for room, however long the disk takes, and
  /// logs that it waits.
  void offer(const RgbdFrame& frame, bool may_wait, std::stop_token stop);

  /// Ends the queue. Of the frames in it, those are written that can be within `drain_for`.
  void end(std::chrono::milliseconds drain_for);

  const std::string& path() const { return recording_.path(); }

  /// Frames that were offered but are not in the recording.
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
  std::atomic<bool> over_ = false;   ///< nothing more can be written
  std::uint64_t said_left_out_ = 0;  ///< of the capture thread, like the next member
  Instant said_left_out_at_{};
  Instant said_refused_at_{}, checkpoint_at_{};  ///< of the recording thread
  std::promise<void> written_;
  std::jthread thread_;
};

}  // namespace copresence::server
