#pragma once

// The text messages between gateway and page: JSON objects with a "type". See
// docs/internals/web_protocol.md. Thread: pure functions.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/frame/rgbd_frame.h"

namespace copresence::forwarding {

struct RoomCamera {
  std::string name;     ///< From the scene file or the camera's stream. Empty if unknown.
  std::string address;  ///< HOST:PORT of its capture server.
};

enum class CameraState {
  kConnecting,  ///< The first try to connect has not ended.
  kConnected,   ///< The server sends frames.
  kWaiting,     ///< There are no frames at present.
  kFailed,      ///< The server refuses this gateway for good.
};

enum class Refusal { kToken, kFull };

/// Returns the token of a page's first message, or nothing if the text is no such message.
std::optional<std::string> parse_join(std::string_view text);

std::string room_message(std::span<const RoomCamera> cameras);
/// `text` is one sentence for a person.
std::string state_message(std::size_t camera, CameraState state, const std::string& text);
/// `offset` is the capture server's clock minus the gateway's clock.
std::string clock_message(std::size_t camera, Duration offset);
std::string refused_message(Refusal reason);

}  // namespace copresence::forwarding
