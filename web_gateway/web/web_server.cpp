#include "web_gateway/web/web_server.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "common/wire/flow_control/admission.h"
#include "web_gateway/web/connection.h"

namespace copresence::web {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using wire::Ending;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSweep{250};
// Pause after accepting failed, since no descriptor is free.
constexpr std::chrono::milliseconds kAcceptAgain{100};

Result<std::unique_ptr<asio::ssl::context>> open_tls(const Certificate& certificate) {
  auto context = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
  error_code error;
  context->set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                       asio::ssl::context::no_tlsv1_1 | asio::ssl::context::no_compression);
  SSL_CTX_set_mode(context->native_handle(), SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_session_cache_mode(context->native_handle(), SSL_SESS_CACHE_OFF);
  context->use_certificate_chain_file(certificate.chain_file, error);
  if (error) {
    return fail(ErrorCode::kInvalid, fmt::format("{} cannot be used as a certificate: {}",
                                                 certificate.chain_file, error.message()));
  }
  context->use_private_key_file(certificate.key_file, asio::ssl::context::pem, error);
  if (error) {  // OpenSSL also compares the key with the certificate.
    return fail(ErrorCode::kInvalid,
                fmt::format("{} cannot be used as the private key of the certificate in {}: {}",
                            certificate.key_file, certificate.chain_file, error.message()));
  }
  return context;
}

}  // namespace

class WebServer::Loop {
 public:
  Loop(ServerOptions options, std::unique_ptr<asio::ssl::context> tls, forwarding::Room& room,
       LogLine log_line)
      : tls_(std::move(tls)), log_line_(std::move(log_line)), server_{room, std::move(options.access)} {
    server_.max_viewers = options.max_viewers;
  }

  Result<void> listen(const wire::ListeningSocket& socket) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    const int descriptor = ::dup(socket.descriptor());
    if (descriptor < 0) return fail(ErrorCode::kUnavailable, "cannot listen: too many open files");
    ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
    acceptor_.assign(address.ss_family == AF_INET6 ? tcp::v6() : tcp::v4(), descriptor);
    return {};
  }

  void run(const std::stop_token& stop) {
    const std::stop_callback halt(stop, [this] { io_.stop(); });
    accept();
    sweep();
    io_.run();
    for (const auto& connection : connections_) connection->close(Ending::kServerEnds);
    forget_closed();
    write_log(Clock::now());
    io_.restart();
    io_.poll();  // Ends all pending operations, so that no viewer outlives this function.
  }

  void post(std::function<void()> task) { asio::post(io_, std::move(task)); }

 private:
  void accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        add(std::move(socket));
        return accept();
      }
      again_.expires_after(kAcceptAgain);
      again_.async_wait([this](const error_code& stopped) {
        if (!stopped) accept();
      });
    });
  }

  void add(tcp::socket socket) {
    auto connection = make_connection(std::move(socket), tls_.get(), server_);
    make_room(*connection);
    connections_.push_back(connection);
    connection->start();
  }

  /// Closes another connection that is no viewer if there are too many of them.
  void make_room(const Connection& newest) {
    forget_closed();
    std::vector<wire::Standing> others;
    std::vector<Connection*> strangers;
    for (const auto& other : connections_) {
      if (other->is_viewer()) continue;
      others.push_back({other->network(), wire::Stage::kStranger, other->began_at(), std::nullopt});
      strangers.push_back(other.get());
    }
    const auto decision = wire::admit(wire::Stage::kStranger, newest.network(), others, Clock::now());
    if (decision.in_exchange_for) strangers[*decision.in_exchange_for]->close(Ending::kMadeRoom);
  }

  void sweep() {
    const Instant now = Clock::now();
    for (const auto& connection : connections_) connection->sweep(now);
    forget_closed();
    write_log(now);
    sweeper_.expires_after(kSweep);
    sweeper_.async_wait([this](const error_code& error) {
      if (!error) sweep();
    });
  }

  void forget_closed() {
    const Instant now = Clock::now();
    const auto closed =
        std::stable_partition(connections_.begin(), connections_.end(),
                              [](const auto& connection) { return !connection->is_closed(); });
    for (auto at = closed; at != connections_.end(); ++at) {
      const Connection& connection = **at;
      if (connection.is_viewer()) {
        server_.log.left(connection.address(), connection.ending(), now - connection.began_at(),
                         server_.viewers, now);
      } else if (connection.ending() != Ending::kHungUp) {  // Browsers that have read the page hang up.
        server_.log.ended_early(connection.network(), connection.ending(), now);
      }
    }
    connections_.erase(closed, connections_.end());
  }

  void write_log(Instant now) {
    for (const wire::ConnectionLog::Line& line : server_.log.take(now)) log_line_(line.text, line.is_warning);
  }

  std::unique_ptr<asio::ssl::context> tls_;  // Null for HTTP.
  LogLine log_line_;
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer sweeper_{io_}, again_{io_};
  Connection::Server server_;
  std::vector<std::shared_ptr<Connection>> connections_;
};

Result<std::unique_ptr<WebServer>> WebServer::open(const wire::ListeningSocket& socket, ServerOptions options,
                                                   forwarding::Room& room, LogLine log_line) {
  std::unique_ptr<asio::ssl::context> tls;
  if (!options.certificate.chain_file.empty()) {
    auto opened = open_tls(options.certificate);
    if (!opened) return fail(opened.error());
    tls = std::move(*opened);
  }
  auto loop = std::make_unique<Loop>(std::move(options), std::move(tls), room, std::move(log_line));
  if (const auto listening = loop->listen(socket); !listening) return fail(listening.error());
  return std::unique_ptr<WebServer>(new WebServer(std::move(loop)));
}

WebServer::WebServer(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
WebServer::~WebServer() = default;

void WebServer::run(const std::stop_token& stop) {
  loop_->run(stop);
}

void WebServer::post(std::function<void()> task) {
  loop_->post(std::move(task));
}

}  // namespace copresence::web
