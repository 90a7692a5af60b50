#pragma once

// Why two ends could not begin to talk, besides what the network reports. Thread: pure functions.

#include <asio/error_code.hpp>

namespace copresence::wire {

enum class TransportError {
  kPeerIsPlain = 1,  ///< This end has a room key, and the peer does not encrypt.
  kPeerIsEncrypted,  ///< This end has no room key, and the peer begins to encrypt.
  kWrongKey,         ///< The peer has another room key.
  kBroken,           ///< The peer violates TLS, or bytes were changed on their way.
};

asio::error_code make_error_code(TransportError error);

}  // namespace copresence::wire

template <>
struct std::is_error_code_enum<copresence::wire::TransportError> : std::true_type {};
