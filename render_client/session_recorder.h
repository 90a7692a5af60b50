#pragma once

// Records a session while it is viewed (--record), on a thread of its own. Frames wait for the disk
// in a queue. If the disk is too slow or full, the recording loses frames and the log says so, but
// no view is delayed. Thread: the pipeline makes and destroys it. Each camera's thread may call
// offer() for its own camera.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "common/flow/bounded_queue.h"
#include "common/frame/coded_frame.h"
#include "common/frame/stream_description.h"
#include "render_client/session/session_writer.h"

namespace copresence::client {

class SessionRecorder {
 public:
  /// Capacity of the queue in frames: four seconds of four cameras, about 10 MB.
  static constexpr std::size_t kMostWaiting = 512;
  /// A replay can jump only to keyframes. A camera has one at least this often.
  static constexpr std::chrono::seconds kKeyframeEvery{5};

  /// Begins to record and logs it.
  SessionRecorder(session::SessionWriter writer, std::size_t cameras);

  /// Writes the waiting frames, for at most 0.7 s, and completes the file.
  ~SessionRecorder();
  SessionRecorder(const SessionRecorder&) = delete;
  SessionRecorder& operator=(const SessionRecorder&) = delete;

  /// Takes over a frame that could be decoded. Never waits for the disk. Returns whether a keyframe
  /// should be requested from the camera.
  bool offer(std::size_t camera, std::shared_ptr<const StreamDescription> description, EncodedFrame frame,
             Instant captured_at);

 private:
  struct Waiting {
    std::size_t camera;
    std::shared_ptr<const StreamDescription> description;
    EncodedFrame frame;
    Instant captured_at;
  };
  struct Camera {
    Instant keyframe_at{}, requested_at{};
    bool has_gap = false;  // Whether a frame was left out since the last keyframe.
  };
  void leave_out(Instant now);
  void run();
  void write(const Waiting& waiting);
  void finish();

  session::SessionWriter writer_;
  flow::BoundedQueue<Waiting> waiting_{kMostWaiting};
  std::vector<Camera> cameras_;  // Each element is used by its camera's thread only.
  std::atomic<std::uint64_t> left_out_ = 0;
  std::atomic<Instant> say_again_at_ = Instant{};
  std::atomic<Instant> give_up_at_ = Instant::max();
  std::atomic<bool> is_over_ = false;  // Whether nothing more can be written.
  std::jthread thread_;
};

}  // namespace copresence::client
