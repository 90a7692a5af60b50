#pragma once

// Replays a session recording to the threads that receive the cameras' frames.
//
// The replay has a position, a time of the recording. Each camera has a source that gives its
// frames up to this position and then waits. So the render thread decides when frames come, and it
// can wait until all frames up to the position have been processed. Views then do not depend on the
// speed of the machine.
//
// Thread: the render thread moves the position. Each camera's thread connects and uses its source.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "render_client/session/session_file.h"
#include "render_client/stream/frame_source.h"

namespace copresence::session {

class Playback {
 public:
  explicit Playback(SessionFile file);

  const SessionFile& file() const { return file_; }

  /// The instant that stands for a time of the recording. All times of replayed frames are such
  /// instants, so they are the same in every replay.
  static Instant instant(Time time) {
    return Instant(std::chrono::hours(1)) + std::chrono::duration_cast<Duration>(time);
  }
  /// The instant of the position.
  Instant now() const;

  /// Moves the position forward. The sources give all frames up to it.
  void advance(Time position);
  /// Jumps to a position. Each camera goes on with its last keyframe before it.
  void seek(Time position);
  /// Waits until every camera's thread has taken all frames up to the position and waits for more,
  /// or until a stop is requested.
  void wait_until_taken(std::stop_token stop);

  /// Returns the time of the first frame of any camera after `time`, or nothing at the end.
  std::optional<Time> next_frame_after(Time time) const;

  /// Waits until the position reaches the camera's next stream, and returns a source of its frames.
  /// At the end it waits for a seek. Fails with kUnavailable if a stop is requested. The source
  /// fails with kEndOfStream at the end of the stream, and when a seek leaves the stream. It must
  /// not outlive this object.
  Result<std::unique_ptr<stream::FrameSource>> connect(std::size_t camera, std::stop_token stop);

 private:
  class Source;
  struct Cursor {
    std::size_t stream = 0, frame = 0;  // The next frame of the camera.
    bool is_waiting = false;            // Whether the camera's thread waits for the position.
  };

  /// Waits until the camera's next frame is due. Returns false at `latest` or on a stop request.
  /// With `stream`, it also returns if the next frame belongs to another stream.
  bool wait_until_due(std::unique_lock<std::mutex>& lock, std::size_t camera,
                      std::optional<std::size_t> stream, std::stop_token stop, std::optional<Instant> latest);
  std::optional<Time> next_time(std::size_t camera) const;
  bool is_due(std::size_t camera) const;
  bool all_taken() const;

  const SessionFile file_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  // The following members are guarded by mutex_.
  Time position_;
  std::vector<Cursor> cursors_;  // By camera.
};

}  // namespace copresence::session
