#pragma once

// Accepts connections to a listening socket. Thread: the thread that runs the io_context.

#include <asio.hpp>
#include <functional>
#include <memory>

#include "common/result.h"
#include "common/wire/listening_socket.h"
#include "common/wire/transport/connection.h"

namespace copresence::wire {

class Acceptor {
 public:
  using Accepted = std::function<void(std::unique_ptr<Connection>)>;

  /// `encryption` is null if connections are not encrypted. `io` and `encryption` must outlive this
  /// object and its connections.
  Acceptor(asio::io_context& io, const tls::Context* encryption)
      : encryption_(encryption), acceptor_(io), again_(io) {}

  /// Duplicates the socket's descriptor, so the caller may keep or close the socket. Fails with
  /// kUnavailable without free file descriptors.
  Result<void> open(const ListeningSocket& socket);

  /// Calls `accepted` with every connection from now on, until close(). Requires an earlier open().
  void run(Accepted accepted);
  void close();

 private:
  void accept();

  const tls::Context* encryption_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer again_;
  Accepted accepted_;
};

}  // namespace copresence::wire
