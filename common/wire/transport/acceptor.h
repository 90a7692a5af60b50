#pragma once

// Accepts the connections that clients open to a listening socket. Thread: the one that runs the
// io_context.

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

  /// `io` must outlive this.
  explicit Acceptor(asio::io_context& io) : acceptor_(io), again_(io) {}

  /// Takes a descriptor of its own for the port: the caller may keep the socket, or close it.
  /// Fails with kUnavailable without file descriptors.
  Result<void> open(const ListeningSocket& socket);

  /// Calls `accepted` with every connection from now on, until close(). Requires open() before.
  void run(Accepted accepted);
  void close();

 private:
  void accept();

  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer again_;
  Accepted accepted_;
};

}  // namespace copresence::wire
