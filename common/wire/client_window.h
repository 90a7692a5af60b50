#pragma once

// How far one client may lag behind: the rule that keeps latency and memory bounded. docs/decisions tells
// why.
//
// A frame is in flight from the moment it is queued for a client until that client acknowledges it, wherever
// it is meanwhile: our queue, the kernel's, the network's, the client's; its lag is how long that takes. A
// client has room while fewer frames than its limit and less than kBytes bytes are in flight. The limit is
// kFrames, and less where frames queue up: when for half a second none came through within two frame periods
// of the smallest lag ever seen, the path or the client carries less than the stream, and every frame above
// what the path itself holds is only older when it arrives.
//
// A frame that a client has no room for is skipped, and with it every frame up to the next keyframe, since
// none of them can be decoded without it. Having skipped, it has room again only when nothing is in flight
// any more: keyframes cost all clients, so they are asked for those that have caught up.
//
// Thread: a value.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class ClientWindow {
 public:
  static constexpr std::size_t kFrames = 8;           ///< 0.27 s at 30 frames per second
  static constexpr std::size_t kBytes = 1024 * 1024;  ///< not counting the frame that crosses the mark

  explicit ClientWindow(Duration frame_period) : frame_period_(frame_period) {}

  bool has_room() const {
    return in_step_ ? in_flight_.size() < limit_ && bytes_ < kBytes : in_flight_.empty();
  }
  /// Nothing was skipped since the last keyframe it got; false before the first one.
  bool in_step() const { return in_step_; }
  bool may_have(bool keyframe) const { return has_room() && (keyframe || in_step_); }

  /// A frame goes out. Requires may_have(keyframe).
  void sent(std::uint64_t sequence, std::size_t bytes, Instant now);
  /// Frames of the stream that this client does not get.
  void skip(std::uint64_t frames);
  /// The client has this frame and all before it. False if it was not in flight: the client makes things up.
  bool acknowledge(std::uint64_t sequence, Instant now);

  std::uint64_t skipped() const { return skipped_; }
  std::size_t frames_in_flight() const { return in_flight_.size(); }
  std::size_t bytes_in_flight() const { return bytes_; }

 private:
  struct Frame {
    std::uint64_t sequence;
    std::size_t bytes;
    Instant sent_at;
  };
  void learn(Duration lag, Instant now);

  Duration frame_period_;
  std::deque<Frame> in_flight_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0;
  bool in_step_ = false;

  std::size_t limit_ = kFrames;
  std::optional<Duration> smallest_lag_;  // ever: what the path itself takes
  struct Round {                          // of half a second: is there a queue that never empties?
    Instant ends_at;
    Duration smallest_lag;
  };
  std::optional<Round> round_;
};

}  // namespace copresence::wire
