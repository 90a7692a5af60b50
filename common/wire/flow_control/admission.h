#pragma once

// Decides which connections a server keeps if more arrive than it can serve.
//
// A connection has one of three stages. A stranger has not sent Hello. A newcomer has sent Hello
// and gets frames, but has not acknowledged a frame. A client has acknowledged a frame. Each stage
// has its own limit, and only clients appear in the numbers that a user sees. So a peer cannot
// occupy a client's slot without receiving pictures.
//
// If strangers or newcomers are at their limit, a new connection replaces the oldest connection of
// the network that has most of them. An attacker therefore replaces mostly its own connections. A
// newcomer becomes a client if there are fewer clients than the limit. Otherwise the newcomer
// replaces a client that has frames in flight and has acknowledged none for 10 s. The server stores
// and bans no addresses. Thread: pure functions.

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

enum class Stage { kStranger, kNewcomer, kClient };

/// Returns the largest number of connections in a stage.
std::size_t room_for(Stage stage);

struct Standing {
  std::string network;  ///< Network of its address: Connection::peer_network().
  Stage stage = Stage::kStranger;
  Instant since{};  ///< When it connected.
  /// When the oldest frame in flight was sent. Empty if no frame is in flight.
  std::optional<Instant> waits_since;
};

struct Decision {
  bool admitted = false;
  std::optional<std::size_t> in_exchange_for;  ///< Index of a connection that must be closed.
};

/// Decides if a connection from `network` may enter `stage`. `others` are all other connections.
Decision admit(Stage stage, const std::string& network, std::span<const Standing> others, Instant now);

}  // namespace copresence::wire
