#pragma once

// Decides which connections a server keeps if more arrive than it can serve.
//
// A connection has one of three stages:
//   stranger   has not sent Hello
//   newcomer   has sent Hello and gets frames, but has not acknowledged one
//   client     has acknowledged a frame
// Each stage has its own limit, and only clients count as such for the user. So nobody can occupy a
// client's place without receiving pictures.
//
// If strangers or newcomers are at their limit, a new connection replaces one of them: the oldest
// one of the network with the most of them. An attacker therefore replaces mostly its own
// connections. A newcomer becomes a client if there are fewer clients than the limit. Otherwise it
// replaces a client that has frames in flight and has acknowledged none for 10 s. No address is
// remembered or banned. Thread: pure functions.

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

enum class Stage { kStranger, kNewcomer, kClient };

/// The largest number of connections in a stage.
std::size_t room_for(Stage stage);

struct Standing {
  std::string network;  ///< of the address it comes from: Connection::peer_network()
  Stage stage = Stage::kStranger;
  Instant since{};  ///< connected at
  std::optional<Instant>
      waits_since;  ///< when the oldest frame in flight was sent; nothing if none is in flight
};

struct Decision {
  bool admitted = false;
  std::optional<std::size_t> in_exchange_for;  ///< index of a connection that must be closed
};

/// Decides whether a connection from `network` may enter `stage`. `others` are all other
/// connections.
Decision admit(Stage stage, const std::string& network, std::span<const Standing> others, Instant now);

}  // namespace copresence::wire
