#pragma once

// The gateway's web server: serves the page over HTTP or HTTPS, and the room over one WebSocket for
// each viewer. At most 128 connections that are no viewers are open at a time; a new one replaces
// the oldest (common/wire/flow_control/admission.h). Thread: one thread calls run(), and the room
// is used on that thread only; any thread may call post().

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "common/result.h"
#include "common/wire/listening_socket.h"
#include "web_gateway/forwarding/room.h"
#include "web_gateway/web/access.h"

namespace copresence::web {

struct Certificate {
  std::string chain_file;  ///< PEM: the server's certificate, then those of its issuers.
  std::string key_file;    ///< PEM, its private key.
};

struct ServerOptions {
  Access access;
  std::size_t max_viewers = 50;
  Certificate certificate;  ///< Empty names for HTTP without TLS.
};

class WebServer {
 public:
  /// Receives at most about two lines a second for the gateway's log.
  using LogLine = std::function<void(const std::string& sentence, bool is_warning)>;

  /// `room` must outlive the server. Fails with kInvalid if the certificate cannot be used, and
  /// with kUnavailable without free file descriptors.
  static Result<std::unique_ptr<WebServer>> open(const wire::ListeningSocket& socket, ServerOptions options,
                                                 forwarding::Room& room, LogLine log_line);
  ~WebServer();

  /// Serves until a stop request.
  void run(const std::stop_token& stop);
  /// Runs `task` on the thread of run().
  void post(std::function<void()> task);

 private:
  class Loop;
  explicit WebServer(std::unique_ptr<Loop> loop);
  std::unique_ptr<Loop> loop_;
};

}  // namespace copresence::web
