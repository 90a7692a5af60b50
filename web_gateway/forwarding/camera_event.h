#pragma once

// What a gateway learns about one of its cameras. Thread: values.

#include <string>
#include <variant>

#include "common/frame/stream_description.h"
#include "common/wire/clock_offset.h"
#include "web_gateway/forwarding/forwarded_frame.h"

namespace copresence::forwarding {

/// A connection to the capture server was made.
struct Connected {
  StreamDescription description;
  wire::ClockOffset clock;
};

struct FrameCame {
  SharedFrame frame;
  wire::ClockOffset clock;
};

/// The server's camera sends no frames for this reason, or sends frames again if the text is empty.
struct StatusChanged {
  std::string text;
};

/// There is no connection. The gateway tries again unless the server refuses it for good.
struct Disconnected {
  std::string why;
  bool ended_the_stream = false;  ///< The server said why it ends; viewers get its message.
  bool is_final = false;          ///< The server refuses this gateway: connecting again is useless.
};

using CameraEvent = std::variant<Connected, FrameCame, StatusChanged, Disconnected>;

}  // namespace copresence::forwarding
