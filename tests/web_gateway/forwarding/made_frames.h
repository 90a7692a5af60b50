#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "web_gateway/forwarding/forwarded_frame.h"

namespace copresence::forwarding {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 33ms;
inline const Instant kBegin = Instant{} + 100s;

inline SharedFrame made_frame(std::uint64_t sequence, bool keyframe, std::size_t depth_bytes = 1000,
                              Instant received_at = kBegin) {
  wire::ReceivedFrame received;
  received.frame.sequence = sequence;
  received.frame.keyframe = keyframe;
  received.frame.depth.assign(depth_bytes, static_cast<std::uint8_t>(sequence));
  received.frame.color = {1, 2, 3};
  received.sent_at = Instant{} + 50s;
  received.received_at = received_at;
  return make_forwarded_frame(7, std::move(received));
}

}  // namespace copresence::forwarding
