#pragma once

// Decides which frames of one camera one viewer gets. The rules are those of the wire
// (common/wire/flow_control/client_window.h): a viewer gets every frame while its window has room.
// If the window is full, the viewer gets nothing until no frame is in flight, and then a keyframe.
//
// A new viewer gets the frames since the last keyframe, as fast as its window allows. Then it gets
// the new frames. If a newer keyframe comes meanwhile, the viewer continues with that one.
// A viewer who fell behind continues with the kept group if its keyframe is newer than what the
// viewer has. Thread: one thread.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/wire/flow_control/client_window.h"
#include "web_gateway/forwarding/frame_group.h"

namespace copresence::forwarding {

class ViewerStream {
 public:
  using Send = std::function<void(const SharedFrame&)>;

  explicit ViewerStream(Duration frame_period) : frame_period_(frame_period), window_(frame_period) {}

  /// The camera has a new connection, so its frames begin again. The viewer gets none of them
  /// before it has acknowledged the frames in flight, since their numbers may come again.
  void restart(Duration frame_period);

  /// The camera's next frame, which is in `group` already if the group keeps it.
  void frame_came(const SharedFrame& frame, const FrameGroup& group, Instant now, const Send& send);
  /// Returns false if the frame is not in flight, which is a protocol error.
  bool acknowledge(std::uint64_t sequence, const FrameGroup& group, Instant now, const Send& send);
  /// Sends what the viewer may get of the group now.
  void catch_up(const FrameGroup& group, Instant now, const Send& send);

  /// True if only a new keyframe lets the viewer continue, or continue without delay.
  bool needs_keyframe(const FrameGroup& group, Instant now) const;
  /// When the oldest frame in flight was sent. Empty if no frame is in flight.
  std::optional<Instant> waits_since() const { return window_.waits_since(); }
  std::size_t frames_in_flight() const { return window_.frames_in_flight(); }

 private:
  enum class Mode {
    kAwaitsKeyframe,
    kCatchingUp,  // The frame at `next_` of the group is the next one.
    kLive,        // The viewer has been sent every frame.
  };
  void give(const SharedFrame& frame, Instant now, const Send& send);
  void fall_behind();

  Duration frame_period_;
  wire::ClientWindow window_;
  Mode mode_ = Mode::kAwaitsKeyframe;
  std::size_t next_ = 0;
  std::uint64_t last_sent_ = 0;  // Sequence number; 0 before the first frame of a connection.
  bool restarted_ = false;       // True until the first frame after restart().
};

}  // namespace copresence::forwarding
