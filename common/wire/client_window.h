#pragma once

// How far one client may lag behind: the rule that keeps latency and memory bounded. docs/decisions tells
// why.
//
// A frame is in flight from the moment it is queued for a client until that client acknowledges it, wherever
// it is meanwhile: our queue, the kernel's, the network's, the client's. A client has room while fewer than
// kFrames frames and less than kBytes bytes are in flight. A frame it has no room for is skipped, and with it
// every frame up to the next keyframe, since none of them can be decoded without it. Having skipped, it has
// room again only when nothing is in flight any more: keyframes cost all clients, so they are asked for those
// that have caught up.
//
// Thread: a value.

#include <cstddef>
#include <cstdint>
#include <deque>

namespace copresence::wire {

class ClientWindow {
 public:
  static constexpr std::size_t kFrames = 8;           ///< 0.27 s at 30 frames per second
  static constexpr std::size_t kBytes = 1024 * 1024;  ///< not counting the frame that crosses the mark

  bool has_room() const {
    return in_step_ ? in_flight_.size() < kFrames && bytes_ < kBytes : in_flight_.empty();
  }
  /// Nothing was skipped since the last keyframe it got; false before the first one.
  bool in_step() const { return in_step_; }
  bool may_have(bool keyframe) const { return has_room() && (keyframe || in_step_); }

  /// A frame goes out. Requires may_have(keyframe).
  void sent(std::uint64_t sequence, std::size_t bytes);
  /// Frames of the stream that this client does not get.
  void skip(std::uint64_t frames);
  /// The client has this frame and all before it. False if it was not in flight: the client makes things up.
  bool acknowledge(std::uint64_t sequence);

  std::uint64_t skipped() const { return skipped_; }
  std::size_t frames_in_flight() const { return in_flight_.size(); }
  std::size_t bytes_in_flight() const { return bytes_; }

 private:
  struct Frame {
    std::uint64_t sequence;
    std::size_t bytes;
  };
  std::deque<Frame> in_flight_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0;
  bool in_step_ = false;
};

}  // namespace copresence::wire
