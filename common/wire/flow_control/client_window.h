#pragma once

// Decides which frames one client gets, so that latency and memory stay bounded whatever the path to it is
// like. docs/decisions/0002-window-per-client.md gives the reasons.
//
// A frame is in flight from being queued for a client until that client acknowledges it. The expected time
// until everything in flight has arrived is bounded by the path's base delay (path_estimate.h) plus an
// allowance for queueing. There are two allowances:
//  - wants_until(): the client would like another frame. The allowance is 8 frame periods. It becomes 2 when
//    for half a second every frame was delayed by more than that, which means that a queue never empties. It
//    grows back by one per half second. When no client wants a frame, the encoder pauses, so frames of a slow
//    path are not encoded only to wait.
//  - may_have(): the client takes a frame that was encoded for others. The allowance is 500 ms, and up to 300
//    ms more behind a keyframe that takes as long. Leaving the frame out would cost a keyframe.
// While the path is unknown, 2 and 6 frames may be in flight.
//
// A frame that a client may not have is skipped, and with it every frame up to the next keyframe, since none
// of them can be decoded without it. After that the client may have a keyframe once nothing is in flight to
// it.
//
// Thread: a value.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/flow_control/path_estimate.h"

namespace copresence::wire {

class ClientWindow {
 public:
  static constexpr std::size_t kFrames = 64;          ///< in flight, on any path
  static constexpr std::size_t kBytes = 1024 * 1024;  ///< not counting the frame that crosses the mark
  static constexpr std::size_t kFramesOnUnknownPath = 6;

  explicit ClientWindow(Duration frame_period);

  /// In sync: it got every frame since a keyframe, and can decode the next one. False before the first frame.
  bool in_sync() const { return in_sync_; }
  /// It was sent a frame, and later ones were skipped.
  bool fell_behind() const { return !in_sync_ && has_begun_; }
  /// Not in sync, and nothing is in flight: the next keyframe is welcome.
  bool awaits_keyframe() const { return !in_sync_ && in_flight_.empty(); }
  /// Until when a client in sync wants another frame, if nothing happens meanwhile; a time in the past for
  /// one that does not.
  Instant wants_until() const;
  bool may_have(bool keyframe, Instant now) const;

  /// A frame goes out. Requires may_have(keyframe, now).
  void sent(std::uint64_t sequence, std::size_t bytes, Instant now);
  /// Frames of the stream that this client does not get.
  void skip(std::uint64_t frames);
  /// The client has this frame and all before it. Returns false for a frame that is not in flight: a protocol
  /// error.
  bool acknowledge(std::uint64_t sequence, Instant now);

  std::uint64_t skipped() const { return skipped_; }
  std::uint64_t acknowledged() const { return acknowledged_; }  ///< frames
  std::size_t frames_in_flight() const { return in_flight_.size(); }
  std::size_t bytes_in_flight() const { return bytes_; }
  /// When the oldest frame in flight was sent; nothing where there is none.
  std::optional<Instant> waits_since() const;
  const PathEstimate& path() const { return path_; }

 private:
  struct Frame {
    std::uint64_t sequence;
    PathEstimate::Sent sent;
  };
  Instant room_until(Duration allowance, std::size_t frames_on_unknown_path) const;
  void adapt_allowance(Instant now);

  Duration frame_period_;
  PathEstimate path_;
  std::deque<Frame> in_flight_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0, acknowledged_ = 0;
  bool in_sync_ = false, has_begun_ = false;

  Duration allowance_;
  struct Round {  // half a second: is there a queue that never empties?
    Instant ends_at;
    Duration least_queueing;
  };
  std::optional<Round> round_;
};

}  // namespace copresence::wire
