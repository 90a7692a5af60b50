#include "web_gateway/forwarding/page_messages.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "common/wire/message.h"

namespace copresence::forwarding {
namespace {

using nlohmann::json;

/// Texts of servers are valid UTF-8; anything else is replaced.
std::string dump(const json& message) {
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

const char* word(CameraState state) {
  switch (state) {
    case CameraState::kConnecting:
      return "connecting";
    case CameraState::kConnected:
      return "connected";
    case CameraState::kWaiting:
      return "waiting";
    case CameraState::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace

std::optional<std::string> parse_join(std::string_view text) {
  const json message = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return std::nullopt;
  const auto type = message.find("type"), token = message.find("token");
  if (type == message.end() || *type != "join") return std::nullopt;
  if (token == message.end() || !token->is_string()) return std::nullopt;
  return token->get<std::string>();
}

std::string room_message(std::span<const RoomCamera> cameras) {
  json listed = json::array();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    listed.push_back({{"index", i}, {"name", cameras[i].name}, {"address", cameras[i].address}});
  }
  return dump({{"type", "room"}, {"protocol", wire::kProtocolVersion}, {"cameras", listed}});
}

std::string state_message(std::size_t camera, CameraState state, const std::string& text) {
  return dump({{"type", "state"}, {"camera", camera}, {"state", word(state)}, {"text", text}});
}

std::string clock_message(std::size_t camera, Duration offset) {
  const auto microseconds = std::chrono::duration_cast<std::chrono::microseconds>(offset).count();
  return dump({{"type", "clock"}, {"camera", camera}, {"offset_us", microseconds}});
}

std::string refused_message(Refusal reason) {
  const bool token = reason == Refusal::kToken;
  return dump(
      {{"type", "refused"},
       {"reason", token ? "token" : "full"},
       {"text", token ? "this link has no valid token: ask the person who runs the room for a new link"
                      : "the room has as many viewers as it takes: try again later"}});
}

}  // namespace copresence::forwarding
