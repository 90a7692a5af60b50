#pragma once

// Decides which connections a server keeps when more come than it has room for.
//
// A connection passes three stages. A stranger has not said hello. A newcomer has said hello and gets frames,
// but has not acknowledged one yet. A client has acknowledged a frame. Only clients take one of the places
// that an operator counts, and each stage has room of its own, so nobody can take a place, or keep one,
// without receiving pictures.
//
// When a stage of strangers or newcomers is full, one more is let in for the oldest of the network that has
// most of them: an attacker displaces himself first, and everybody has time to prove that he is a viewer. A
// newcomer becomes a client when a place is free, or held by a client that has not acknowledged anything for
// 10 s though frames are on their way to it. Nobody is remembered or banned.
//
// Thread: pure.

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

enum class Stage { kStranger, kNewcomer, kClient };

/// How many connections of one stage a server keeps.
std::size_t room_for(Stage stage);

struct Standing {
  std::string network;  ///< of the address it comes from: Connection::peer_network()
  Stage stage = Stage::kStranger;
  Instant since{};                     ///< connected at
  std::optional<Instant> waits_since;  ///< the oldest frame on its way to it; nothing where none is
};

struct Decision {
  bool admitted = false;
  std::optional<std::size_t> in_exchange_for;  ///< index of the connection to close first
};

/// Whether one more connection from `network` may enter `stage`. `others` are all connections except that
/// one.
Decision admit(Stage stage, const std::string& network, std::span<const Standing> others, Instant now);

}  // namespace copresence::wire
