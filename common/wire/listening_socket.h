#pragma once

// A listening TCP socket. The supervising parent process creates the socket, and its child process
// serves it. So the port stays open while a crashed child is replaced. Thread: distinct objects are
// independent.

#include <string>

#include "common/result.h"

namespace copresence::wire {

class ListeningSocket {
 public:
  /// Takes ownership of a descriptor that the parent process left open. Fails with kInvalid if the
  /// descriptor is not a listening TCP socket; the descriptor then stays open.
  static Result<ListeningSocket> adopt(int descriptor);

  ListeningSocket(ListeningSocket&& other) noexcept;
  ListeningSocket& operator=(ListeningSocket&& other) noexcept;
  ~ListeningSocket();

  int descriptor() const { return descriptor_; }  ///< Close-on-exec and non-blocking.
  std::string address() const;  ///< HOST:PORT with the real port, also if port 0 was requested.
  bool is_loopback() const;     ///< True if only this machine can connect.

 private:
  explicit ListeningSocket(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;  // A moved-from socket has -1.
};

/// Who may reach a listening socket. Other machines may only if the stream is encrypted, or if the
/// user has allowed an unencrypted one.
enum class Reach { kThisMachine, kOtherMachines };

/// Listens on HOST:PORT. Port 0 selects a free port. Fails with kInvalid if the text is not an
/// address, or if other machines can reach the address and `reach` is kThisMachine. Fails with
/// kNotFound for an unknown host and kUnavailable for a port in use.
Result<ListeningSocket> listen(const std::string& host_port, Reach reach);

}  // namespace copresence::wire
