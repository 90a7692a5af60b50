#include "web_gateway/forwarding/frame_group.h"

namespace copresence::forwarding {

void FrameGroup::add(const SharedFrame& frame) {
  if (frame->frame.keyframe) {
    clear();
  } else if (frames_.empty()) {
    return;
  }
  if (bytes_ + frame->bytes() > kMostBytes) return clear();
  frames_.push_back(frame);
  bytes_ += frame->bytes();
}

void FrameGroup::clear() {
  frames_.clear();
  bytes_ = 0;
}

}  // namespace copresence::forwarding
