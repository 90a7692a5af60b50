#pragma once

// TLS 1.3 between two ends that share a room key. The key is an external pre-shared key (RFC 8446,
// section 2.2), so there are no certificates: an end that completes the handshake has proved that
// it has the key. A fresh Diffie-Hellman exchange keeps recorded connections secret, even from
// somebody who gets the key later.
//
// Both sides accept one cipher suite, TLS_AES_128_GCM_SHA256, and one group, X25519. There are no
// session tickets, no early data and no renegotiation. docs/decisions/0007-tls-with-a-room-key.md
// has the reasons.
//
// A session encrypts and decrypts; a Carrier moves the encrypted bytes. No function blocks. Thread:
// a context may be shared by threads; a session and its carrier belong to one thread.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "common/result.h"
#include "common/tls/room_key.h"

namespace copresence::tls {

enum class Side { kClient, kServer };

/// The settings of one side. All its sessions use the same key.
class Context {
 public:
  /// Fails with kUnsupported if the installed OpenSSL lacks TLS 1.3 or the cipher suite.
  static Result<Context> make(Side side, const RoomKey& key);
  Context(Context&&) noexcept;
  Context& operator=(Context&&) noexcept;
  ~Context();

 private:
  friend class Session;
  struct State;
  explicit Context(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Moves encrypted bytes, for example over a socket. Both functions return the number of bytes, or
/// -1 with the reason in errno: EAGAIN if they would have to wait.
class Carrier {
 public:
  virtual ~Carrier() = default;
  virtual std::ptrdiff_t receive(std::span<std::uint8_t> to) = 0;  ///< 0 at the end of the stream.
  virtual std::ptrdiff_t send(std::span<const std::uint8_t> from) = 0;
};

enum class Outcome {
  kDone,
  kMustReceive,    ///< Call the function again when the carrier can receive.
  kMustSend,       ///< Call the function again when the carrier can send.
  kEnded,          ///< The peer has ended the stream.
  kCarrierFailed,  ///< The carrier reported an error.
  kWrongKey,       ///< One end has another key, or cannot prove that it has this one.
  kBroken,         ///< The peer violated TLS, or changed bytes on their way.
};

class Session {
 public:
  /// `context` and `carrier` must outlive the session.
  Session(const Context& context, Carrier& carrier);
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  /// Continues the handshake. kDone means that both ends have proved that they have the key.
  Outcome handshake();

  // The next functions require a complete handshake. After kEnded and all outcomes below it, the
  // session cannot be used any more.

  /// Reads at most `to.size()` bytes. `got` is their number after kDone. Requires a nonempty `to`.
  Outcome read(std::span<std::uint8_t> to, std::size_t& got);
  /// Encrypts bytes of `from` in one record. `taken` is their number after kDone, at most
  /// kMostInRecord. After kMustSend and kMustReceive, call it again with the same bytes. Requires a
  /// nonempty `from`.
  Outcome write(std::span<const std::uint8_t> from, std::size_t& taken);
  /// Tells the peer that no more bytes follow. Does nothing if the carrier cannot send now.
  void end_writing();

  static constexpr std::size_t kMostInRecord = 16 * 1024;
  /// After this many written records the session changes its key. AES-GCM is safe for at most 2^24.5
  /// records with one key (RFC 8446, section 5.5); a stream of days has more.
  static constexpr std::uint64_t kRecordsOfAKey = 1 << 16;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace copresence::tls
