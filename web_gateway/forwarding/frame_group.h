#pragma once

// Keeps a camera's newest keyframe and all frames after it, so that a viewer who joins sees a
// picture without waiting for a new keyframe. The memory is bounded: a group that becomes larger
// than kMostBytes is dropped, and joining viewers need a new keyframe. Thread: one thread.

#include <cstddef>
#include <vector>

#include "web_gateway/forwarding/forwarded_frame.h"

namespace copresence::forwarding {

class FrameGroup {
 public:
  static constexpr std::size_t kMostBytes = 2 * 1024 * 1024;

  /// Adds the camera's next frame. A keyframe begins a new group.
  void add(const SharedFrame& frame);
  /// Drops all frames until the next keyframe.
  void clear();

  /// The keyframe and every frame since. Empty if the group was dropped or has not begun.
  const std::vector<SharedFrame>& frames() const { return frames_; }

 private:
  std::vector<SharedFrame> frames_;
  std::size_t bytes_ = 0;
};

}  // namespace copresence::forwarding
