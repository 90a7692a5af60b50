#include "web_gateway/forwarding/forwarded_frame.h"

#include <algorithm>
#include <utility>

namespace copresence::forwarding {

SharedFrame make_forwarded_frame(std::uint8_t camera, wire::ReceivedFrame received) {
  wire::FrameHead head;
  head.keyframe = received.frame.keyframe;
  head.sequence = received.frame.sequence;
  head.sent_at = received.sent_at;
  head.counters = received.counters;
  head.durations = received.frame.durations;
  head.depth_bytes = static_cast<std::uint32_t>(received.frame.depth.size());
  head.color_bytes = static_cast<std::uint32_t>(received.frame.color.size());
  const wire::FrameHeadMessage message = wire::encode(head);

  auto frame = std::make_shared<ForwardedFrame>();
  frame->prefix[0] = camera;
  std::copy(message.begin(), message.end(), frame->prefix.begin() + 1);
  frame->frame = std::move(received.frame);
  frame->received_at = received.received_at;
  return frame;
}

}  // namespace copresence::forwarding
