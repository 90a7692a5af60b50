#pragma once

// A frame on its way through the gateway. All viewers share it, so that a frame is in memory once.
// Thread: immutable after it was made.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "common/frame/coded_frame.h"
#include "common/frame/rgbd_frame.h"
#include "common/wire/frame_client.h"
#include "common/wire/message_codec.h"

namespace copresence::forwarding {

struct ForwardedFrame {
  /// The camera's index, then header and head of the wire's frame message. The depth and colour of
  /// `frame` follow.
  std::array<std::uint8_t, 1 + wire::kHeaderBytes + wire::kFrameHeadBytes> prefix{};
  EncodedFrame frame;
  Instant received_at{};

  std::size_t bytes() const { return prefix.size() + frame.depth.size() + frame.color.size(); }
};

using SharedFrame = std::shared_ptr<const ForwardedFrame>;

/// Restores the message as the capture server sent it, byte by byte. A message has only one
/// encoding, so the decoded head is enough.
SharedFrame make_forwarded_frame(std::uint8_t camera, wire::ReceivedFrame received);

}  // namespace copresence::forwarding
