#pragma once

// The port a server listens on. Made by the supervising parent, served by its child: the port stays the
// parent's while a crashed child is replaced.
//
// Thread: a value; one thread at a time.

#include <string>

#include "common/result.h"

namespace copresence::wire {

class ListeningSocket {
 public:
  /// Takes over a descriptor inherited from the parent. Fails with kInvalid if it is not a listening TCP
  /// socket (and leaves it alone).
  static Result<ListeningSocket> adopt(int descriptor);

  ListeningSocket(ListeningSocket&& other) noexcept;
  ListeningSocket& operator=(ListeningSocket&& other) noexcept;
  ~ListeningSocket();

  int descriptor() const { return descriptor_; }  ///< close-on-exec; non-blocking
  std::string address() const;  ///< HOST:PORT as bound: names the port where 0 was asked for

 private:
  explicit ListeningSocket(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;  // -1: moved from
};

/// Listens on HOST:PORT; port 0 takes a free one.
///
/// Fails  kInvalid for what is no address, and for one that other machines can reach unless `insecure`:
/// nothing is
///        encrypted yet; kNotFound for an unknown host; kUnavailable for a port in use.
Result<ListeningSocket> listen(const std::string& host_port, bool insecure);

}  // namespace copresence::wire
