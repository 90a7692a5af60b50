#pragma once

// Decides which frames one client gets, so that latency and memory stay bounded on any network
// path. See docs/decisions/0002-window-per-client.md for the reasons.
//
// A frame is in flight from the time it is queued for a client until that client acknowledges it.
// The client gets a frame only if all frames in flight are expected to arrive within the path's
// base delay (path_estimate.h) plus an allowance for queueing. There are two allowances:
//
// `wants_until()`: the client requests another frame. The allowance is 8 frame periods. If every
// frame of half a second was delayed by more than that, the queue never empties, and the allowance
// becomes 2 periods. The allowance then grows by one period per half second. If 2 periods do not
// help, the client requests nothing until the path is empty. This pause distinguishes a longer path
// from a queue. The encoder pauses if no client requests a frame.
//
// `can_accept()`: the client accepts a frame that was encoded for others, since skipping it would
// cost a keyframe. The allowance is 500 ms, and up to 300 ms more behind a slow keyframe.
//
// While the path's delivery rate is unknown, a client requests a frame if fewer than 2 frames are
// in flight, and accepts one if fewer than 6 are. The client gets no frame while an acknowledgement
// is overdue, since the path has then stopped or become much slower. The time after which it is
// overdue follows the path's jitter: twice the largest lateness of the last seconds plus one
// period. That time is at least 3 periods for requested frames and 5 for accepted frames. After a
// skipped frame, the client cannot decode any frame before the next keyframe. The client can accept
// a keyframe once no frame is in flight to it. Thread: distinct objects are independent.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/flow_control/path_estimate.h"

namespace copresence::wire {

class ClientWindow {
 public:
  /// Largest numbers of frames in flight: in all cases, and while the delivery rate is unknown.
  static constexpr std::size_t kFrames = 64, kFramesOnUnknownPath = 6;
  /// Largest number of bytes in flight. The last frame may exceed this limit.
  static constexpr std::size_t kBytes = 1024 * 1024;

  explicit ClientWindow(Duration frame_period);

  /// True if the client got every frame since a keyframe, so that it can decode the next frame.
  /// False before the first frame.
  bool in_sync() const { return in_sync_; }
  /// True if the client was sent a frame and later frames were skipped.
  bool fell_behind() const { return !in_sync_ && has_begun_; }
  /// True if the client can accept only a keyframe: it is not in sync, and no frame is in flight.
  bool awaits_keyframe() const { return !in_sync_ && in_flight_.empty(); }
  /// Returns the time until which a client in sync requests another frame, unless a frame is sent
  /// or acknowledged before. The time is in the past if the client requests no frame at present.
  Instant wants_until() const;
  bool can_accept(bool keyframe, Instant now) const;

  /// Counts a frame as sent. Requires can_accept(keyframe, now).
  void sent(std::uint64_t sequence, std::size_t bytes, Instant now);
  /// Counts frames of the stream that are not sent to this client.
  void skip(std::uint64_t frames);
  /// Reports that the client has this frame and all earlier frames. Returns false if the frame is
  /// not in flight, which is a protocol error.
  bool acknowledge(std::uint64_t sequence, Instant now);

  std::uint64_t skipped() const { return skipped_; }
  std::uint64_t acknowledged() const { return acknowledged_; }
  std::size_t frames_in_flight() const { return in_flight_.size(); }
  std::size_t bytes_in_flight() const { return bytes_; }
  /// When the oldest frame in flight was sent. Returns nothing if no frame is in flight.
  std::optional<Instant> waits_since() const;
  const PathEstimate& path() const { return path_; }

 private:
  struct Frame {
    std::uint64_t sequence;
    PathEstimate::Sent sent;
  };
  struct Limits {
    Duration allowance;
    int overdue_periods;  // Minimum delay that counts as overdue, in frame periods.
    std::size_t frames_on_unknown_path;
  };
  Instant room_until(const Limits& limits) const;
  Instant next_acknowledgement_due() const;
  void measure_lateness(Instant now);
  void adapt_allowance(Instant now);

  Duration frame_period_;
  PathEstimate path_;
  std::deque<Frame> in_flight_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0, acknowledged_ = 0;
  bool in_sync_ = false, has_begun_ = false;

  Duration allowance_;
  struct Round {  // Lasts half a second.
    Instant ends_at;
    Duration least_queueing;
  };
  std::optional<Round> round_;
  bool drains_ = false;  // True to request nothing until no frame is in flight.

  // Largest lateness of the current span of 5 s, and of the span before.
  Duration lateness_{}, lateness_before_{};
  Instant span_began_at_{}, acknowledged_at_{};
};

}  // namespace copresence::wire
