#pragma once

// Recognises from its first bytes what a peer speaks, before anything is allocated for it. Thread:
// pure functions.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace copresence::wire {

/// The first bytes of a connection. Every message of this project is at least as long.
inline constexpr std::size_t kOpeningBytes = 9;

struct Opening {
  enum class Kind {
    kPlain,   ///< Not TLS.
    kTls,     ///< A TLS record with a ClientHello.
    kBroken,  ///< Looks like TLS, but no ClientHello that this project accepts.
  };
  Kind kind = Kind::kPlain;
  /// With kTls, the size of the whole record, at most kMostOfAClientHello.
  std::size_t record_bytes = 0;
};

/// The largest ClientHello that a server accepts, in bytes. That of a client of this project has
/// about 250 bytes.
inline constexpr std::size_t kMostOfAClientHello = 2048;

/// Judges the first bytes that a client sends.
Opening recognise(std::span<const std::uint8_t, kOpeningBytes> bytes);

/// True if a server's first byte is that of a TLS handshake or alert.
bool answers_in_tls(std::uint8_t first_byte);

}  // namespace copresence::wire
