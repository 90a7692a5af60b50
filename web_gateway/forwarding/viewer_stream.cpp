#include "web_gateway/forwarding/viewer_stream.h"

#include <chrono>
#include <utility>

namespace copresence::forwarding {
namespace {

// A viewer who is this far behind while it catches up needs a new keyframe.
constexpr std::chrono::milliseconds kFarBehind{500};

}  // namespace

void ViewerStream::restart(Duration frame_period) {
  frame_period_ = frame_period;
  last_sent_ = 0;
  restarted_ = true;
  fall_behind();
}

void ViewerStream::frame_came(const SharedFrame& frame, const FrameGroup& group, Instant now,
                              const Send& send) {
  const bool keyframe = frame->frame.keyframe;
  if (mode_ == Mode::kLive && window_.can_accept(keyframe, now)) return give(frame, now, send);
  const bool lost_its_place = mode_ == Mode::kCatchingUp && (keyframe || next_ >= group.frames().size());
  if (mode_ == Mode::kLive || lost_its_place) fall_behind();
  catch_up(group, now, send);
}

bool ViewerStream::acknowledge(std::uint64_t sequence, const FrameGroup& group, Instant now,
                               const Send& send) {
  if (!window_.acknowledge(sequence, now)) return false;
  catch_up(group, now, send);
  return true;
}

void ViewerStream::catch_up(const FrameGroup& group, Instant now, const Send& send) {
  const auto& frames = group.frames();
  if (mode_ == Mode::kAwaitsKeyframe && window_.awaits_keyframe() && !frames.empty() &&
      frames.front()->frame.sequence > last_sent_) {
    if (std::exchange(restarted_, false)) window_ = wire::ClientWindow(frame_period_);
    mode_ = Mode::kCatchingUp;
    next_ = 0;
  }
  if (mode_ != Mode::kCatchingUp) return;
  while (next_ < frames.size() && window_.can_accept(frames[next_]->frame.keyframe, now)) {
    give(frames[next_++], now, send);
  }
  if (next_ >= frames.size()) mode_ = Mode::kLive;
}

bool ViewerStream::needs_keyframe(const FrameGroup& group, Instant now) const {
  if (mode_ == Mode::kAwaitsKeyframe) return window_.awaits_keyframe();
  return mode_ == Mode::kCatchingUp && next_ < group.frames().size() &&
         now - group.frames()[next_]->received_at > kFarBehind;
}

void ViewerStream::give(const SharedFrame& frame, Instant now, const Send& send) {
  window_.sent(frame->frame.sequence, frame->bytes(), now);
  last_sent_ = frame->frame.sequence;
  send(frame);
}

void ViewerStream::fall_behind() {
  window_.skip(1);
  mode_ = Mode::kAwaitsKeyframe;
}

}  // namespace copresence::forwarding
