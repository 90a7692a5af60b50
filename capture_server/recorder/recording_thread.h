#pragma once

// Records in parallel to the stream, on its own thread with a bounded queue. If the disk is slow or
// full, the recording loses frames, which are counted and logged, but the stream loses none.
// Thread: the pipeline creates, uses and destroys it. Only the capture thread calls offer().

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
  /// Capacity of the queue in frames: one second, 50 MB at 640x480.
  static constexpr std::size_t kMostWaiting = 32;

  /// Begins to record and logs its progress.
  explicit RecordingThread(FrameRecording recording);

  /// Waits until the frames that end() left in the queue are written, however long the disk takes,
  /// and logs that it waits. Without end(), frames in the queue are dropped.
  ~RecordingThread();
  RecordingThread(const RecordingThread&) = delete;
  RecordingThread& operator=(const RecordingThread&) = delete;

  /// Copies the frame into the queue. If the queue is full, the frame is counted as left out. With
  /// `may_wait`, for sources that can wait, the call instead waits for room in the queue, however
  /// long the disk takes, and logs that.
  void offer(const RgbdFrame& frame, bool may_wait, std::stop_token stop);

  /// Closes the queue. The recording thread writes the remaining frames for at most `drain_for`.
  void end(std::chrono::milliseconds drain_for);

  const std::string& path() const { return recording_.path(); }

  /// Number of offered frames that are not in the recording.
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
  std::atomic<bool> over_ = false;   ///< True if nothing more can be written.
  std::uint64_t said_left_out_ = 0;  ///< Only the capture thread uses this and the next member.
  Instant said_left_out_at_{};
  Instant said_refused_at_{}, checkpoint_at_{};  ///< Only the recording thread uses these.
  std::promise<void> written_;
  std::jthread thread_;
};

}  // namespace copresence::server
