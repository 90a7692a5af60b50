#pragma once

// One connection of a browser to the web server: first HTTP requests, then perhaps the WebSocket of
// a viewer. Private to this module. Thread: the web thread.

#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <cstddef>
#include <memory>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/wire/connection_log.h"
#include "common/wire/flow_control/admission.h"
#include "web_gateway/forwarding/room.h"
#include "web_gateway/web/access.h"

namespace copresence::web {

class Connection {
 public:
  /// State that all connections share. It must outlive them.
  struct Server {
    forwarding::Room& room;
    Access access;
    std::size_t max_viewers = 0;
    std::size_t viewers = 0;
    wire::ConnectionLog log{};
  };

  virtual ~Connection() = default;

  virtual void start() = 0;
  virtual void close(wire::Ending why) = 0;
  /// Closes a connection that takes too long. Call this a few times a second.
  virtual void sweep(Instant now) = 0;

  virtual bool is_closed() const = 0;
  virtual bool is_viewer() const = 0;
  virtual wire::Ending ending() const = 0;  ///< Requires is_closed().

  const std::string& address() const { return address_; }
  const std::string& network() const { return network_; }
  Instant began_at() const { return began_at_; }

 protected:
  explicit Connection(const boost::asio::ip::tcp::endpoint& peer);

 private:
  std::string address_, network_;
  Instant began_at_;
};

/// Serves an accepted socket: over TLS with `tls`, or over TCP if `tls` is null.
std::shared_ptr<Connection> make_connection(boost::asio::ip::tcp::socket socket,
                                            boost::asio::ssl::context* tls, Connection::Server& server);

}  // namespace copresence::web
