#include "web_gateway/web/connection.h"

#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/beast/core.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "web_gateway/web/responses.h"

namespace copresence::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using wire::Ending;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRequestTime{5};  // For a whole request, and for a TLS handshake.
constexpr std::chrono::seconds kJoinTime{5};     // From opening a WebSocket to its first message.
constexpr std::chrono::seconds kGoodbyeTime{1};
// A browser answers the WebSocket's pings even if the page does nothing. They are sent every 15 s.
constexpr std::chrono::seconds kSilence{30};
constexpr std::chrono::seconds kFrameTime{60};  // Longest time from sending a frame to its ack.

constexpr std::uint32_t kMostHeaderBytes = 8 * 1024;
// Largest message of a page, in bytes. Real messages are much smaller.
constexpr std::size_t kMostMessageBytes = 1024;
// Limit of queued messages to a viewer that are no frames. Frames are limited by the windows.
constexpr std::size_t kMostSmallMessages = 512;
constexpr int kSendBuffer = 256 * 1024;  // A keyframe of one camera fits.

std::string address_of(const tcp::endpoint& endpoint) {
  const std::string host = endpoint.address().to_string();
  return fmt::format(fmt::runtime(endpoint.address().is_v6() ? "[{}]:{}" : "{}:{}"), host, endpoint.port());
}

/// The block of addresses that one party usually controls, as wire::Connection::peer_network().
std::string network_of(const asio::ip::address& address) {
  if (address.is_v4()) return address.to_string();
  if (address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6()).to_string();
  }
  auto bytes = address.to_v6().to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return asio::ip::make_address_v6(bytes).to_string() + "/64";
}

/// Sends small messages at once and finds a vanished peer. A socket works without these options, so
/// failures are ignored.
void set_options(tcp::socket& socket) {
  const auto set = [&socket](int level, int name, int value) {
    ::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_SNDBUF, kSendBuffer);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  // A stopped browser may accept no bytes for a while, so the time is as long as kSilence.
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 30'000);
}

bool is_frame(const forwarding::ViewerMessage& message) {
  return std::holds_alternative<forwarding::SharedFrame>(message);
}

using Buffers = std::array<asio::const_buffer, 3>;

struct BuffersOf {
  Buffers operator()(const std::string& text) const { return {asio::buffer(text)}; }
  Buffers operator()(const wire::Bytes& bytes) const { return {asio::buffer(bytes)}; }
  Buffers operator()(const forwarding::SharedFrame& frame) const {
    return {asio::buffer(frame->prefix), asio::buffer(frame->frame.depth), asio::buffer(frame->frame.color)};
  }
};

/// `Stream` is beast::tcp_stream, or TLS over it.
template <class Stream>
class ConnectionOver final : public Connection,
                             public forwarding::Outlet,
                             public std::enable_shared_from_this<ConnectionOver<Stream>> {
 public:
  ConnectionOver(const tcp::endpoint& peer, Stream stream, Server& server)
      : Connection(peer), server_(server), stream_(std::move(stream)) {}

  void start() override {
    if constexpr (kIsTls) {
      lowest().expires_after(kRequestTime);
      stream_->async_handshake(asio::ssl::stream_base::server, [self = self()](const error_code& error) {
        error ? self->close(Ending::kHungUp) : self->read_request();
      });
    } else {
      read_request();
    }
  }

  void close(Ending why) override {
    if (phase_ == Phase::kClosed) return;
    if (phase_ != Phase::kLeaving) ending_ = why;
    if (phase_ == Phase::kViewing) --server_.viewers;
    phase_ = Phase::kClosed;
    lowest().close();
    // The room may be sending to this viewer at the moment, so the viewer leaves later.
    asio::post(lowest().get_executor(), [self = self()] { self->viewer_.reset(); });
  }

  void sweep(Instant now) override {
    if (phase_ == Phase::kViewing) {
      const auto waits_since = viewer_->waits_since();
      if (waits_since && now - *waits_since >= kFrameTime) close(Ending::kNoProgress);
    } else if (overdue_at_ && now >= *overdue_at_) {
      close(Ending::kNoHello);
    }
  }

  bool is_closed() const override { return phase_ == Phase::kClosed; }
  bool is_viewer() const override { return was_viewer_; }
  Ending ending() const override { return ending_; }

  void send(forwarding::ViewerMessage message) override {
    if (phase_ != Phase::kViewing && phase_ != Phase::kLeaving) return;
    if (!is_frame(message) && ++small_messages_ > kMostSmallMessages) return close(Ending::kNonsense);
    queue_.push_back(std::move(message));
    if (!writing_) write();
  }

 private:
  enum class Phase { kHttp, kOpening, kStranger, kViewing, kLeaving, kClosed };
  static constexpr bool kIsTls = !std::is_same_v<Stream, beast::tcp_stream>;

  std::shared_ptr<ConnectionOver> self() { return this->shared_from_this(); }
  beast::tcp_stream& lowest() {
    return websocket_ ? beast::get_lowest_layer(*websocket_) : beast::get_lowest_layer(*stream_);
  }

  // HTTP.

  void read_request() {
    parser_.emplace();
    parser_->header_limit(kMostHeaderBytes);
    parser_->body_limit(0);
    lowest().expires_after(kRequestTime);
    http::async_read(*stream_, buffer_, *parser_,
                     [self = self()](const error_code& error, std::size_t) { self->on_request(error); });
  }

  void on_request(const error_code& error) {
    if (phase_ == Phase::kClosed) return;
    if (error == http::error::header_limit) {
      return answer(respond_with(http::status::request_header_fields_too_large,
                                 "the request's headers are too long", closing_request()));
    }
    if (error == http::error::unexpected_body || error == http::error::body_limit) {
      return answer(
          respond_with(http::status::payload_too_large, "a request here has no body", closing_request()));
    }
    if (error) return close(Ending::kHungUp);
    const Request& request = parser_->get();
    const std::string_view target(request.target().data(), request.target().size());
    if (websocket::is_upgrade(request) && target == kRoomPath) {
      const std::string_view refused = reason_to_refuse(request, server_.access);
      if (refused.empty()) return open_websocket();
      return answer(respond_with(http::status::forbidden, refused, request));
    }
    answer(respond(request, server_.access));
  }

  /// A request after which the connection is closed.
  static Request closing_request() {
    Request request;
    request.keep_alive(false);
    return request;
  }

  void answer(Response response) {
    response_ = std::move(response);
    lowest().expires_after(kRequestTime);
    http::async_write(*stream_, *response_, [self = self()](const error_code& error, std::size_t) {
      const bool stays = self->response_->keep_alive();
      self->response_.reset();
      if (error || !stays) return self->close(Ending::kHungUp);
      if (self->phase_ != Phase::kClosed) self->read_request();
    });
  }

  // WebSocket.

  void open_websocket() {
    phase_ = Phase::kOpening;
    overdue_at_ = Clock::now() + kJoinTime;
    lowest().expires_never();
    websocket_.emplace(std::move(*stream_));
    stream_.reset();
    websocket_->set_option(websocket::stream_base::timeout{kRequestTime, kSilence, true});
    websocket_->set_option(websocket::stream_base::decorator(
        [](websocket::response_type& response) { set_security_headers(response.base()); }));
    websocket_->read_message_max(kMostMessageBytes);
    websocket_->auto_fragment(false);
    websocket_->async_accept(parser_->get(), [self = self()](const error_code& error) {
      if (error) return self->close(Ending::kHungUp);
      if (self->phase_ == Phase::kClosed) return;
      self->parser_.reset();
      self->buffer_.clear();
      self->phase_ = Phase::kStranger;
      self->read_message();
    });
  }

  void read_message() {
    websocket_->async_read(buffer_, [self = self()](const error_code& error, std::size_t) {
      if (error) return self->close(Ending::kHungUp);
      if (self->phase_ != Phase::kStranger && self->phase_ != Phase::kViewing) return;
      if (!self->take_message()) return self->close(Ending::kNonsense);
      self->buffer_.clear();
      if (self->phase_ == Phase::kViewing) self->read_message();
    });
  }

  bool take_message() {
    const auto bytes = buffer_.cdata();
    const auto* const data = static_cast<const std::uint8_t*>(bytes.data());
    const Instant now = Clock::now();
    if (phase_ == Phase::kViewing) {
      return websocket_->got_binary() && viewer_->take({data, bytes.size()}, now);
    }
    if (!websocket_->got_text()) return false;
    const auto token = forwarding::parse_join({reinterpret_cast<const char*>(data), bytes.size()});
    if (!token) return false;
    if (!server_.access.admits(*token)) {
      refuse(forwarding::Refusal::kToken, Ending::kNoToken);
    } else if (server_.viewers >= server_.max_viewers) {
      refuse(forwarding::Refusal::kFull, Ending::kNoPlace);
    } else {
      join(now);
    }
    return true;
  }

  void join(Instant now) {
    phase_ = Phase::kViewing;
    was_viewer_ = true;
    overdue_at_.reset();
    server_.log.joined(address(), ++server_.viewers, now);
    viewer_ = server_.room.join(*this, now);
  }

  /// Sends the reason and closes the connection once it is sent, or after a second.
  void refuse(forwarding::Refusal reason, Ending why) {
    phase_ = Phase::kLeaving;
    ending_ = why;
    overdue_at_ = Clock::now() + kGoodbyeTime;
    send(forwarding::refused_message(reason));
  }

  void write() {
    writing_ = true;
    const forwarding::ViewerMessage& message = queue_.front();
    websocket_->text(std::holds_alternative<std::string>(message));
    websocket_->async_write(
        std::visit(BuffersOf(), message),
        [self = self()](const error_code& error, std::size_t) { self->on_written(error); });
  }

  void on_written(const error_code& error) {
    writing_ = false;
    if (phase_ == Phase::kClosed) return;
    if (error) return close(Ending::kHungUp);
    if (!is_frame(queue_.front())) --small_messages_;
    queue_.pop_front();
    if (!queue_.empty()) return write();
    if (phase_ != Phase::kLeaving) return;
    websocket_->async_close(websocket::close_code::policy_error,
                            [self = self()](const error_code&) { self->close(Ending::kHungUp); });
  }

  Server& server_;
  Phase phase_ = Phase::kHttp;
  Ending ending_ = Ending::kHungUp;
  std::optional<Instant> overdue_at_;

  std::optional<Stream> stream_;  // Until the WebSocket opens.
  beast::flat_buffer buffer_{2 * kMostHeaderBytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<Response> response_;

  std::optional<websocket::stream<Stream>> websocket_;
  bool was_viewer_ = false;
  std::unique_ptr<forwarding::Viewer> viewer_;
  std::deque<forwarding::ViewerMessage> queue_;
  std::size_t small_messages_ = 0;  // In queue_.
  bool writing_ = false;
};

}  // namespace

Connection::Connection(const tcp::endpoint& peer)
    : address_(address_of(peer)), network_(network_of(peer.address())), began_at_(Clock::now()) {}

std::shared_ptr<Connection> make_connection(tcp::socket socket, asio::ssl::context* tls,
                                            Connection::Server& server) {
  set_options(socket);
  error_code ignored;
  const tcp::endpoint peer = socket.remote_endpoint(ignored);
  beast::tcp_stream stream(std::move(socket));
  if (!tls) return std::make_shared<ConnectionOver<beast::tcp_stream>>(peer, std::move(stream), server);
  using Tls = beast::ssl_stream<beast::tcp_stream>;
  return std::make_shared<ConnectionOver<Tls>>(peer, Tls(std::move(stream), *tls), server);
}

}  // namespace copresence::web
