#include "common/wire/frame_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <asio.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "common/wire/flow_control/arrival_watch.h"
#include "common/wire/host_port.h"
#include "common/wire/message_codec.h"
#include "common/wire/transport/connection.h"
#include "common/wire/transport/name_lookup.h"

namespace copresence::wire {
namespace {

using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFirstPings{100}, kPings{1000};
// The first kFirst pings follow each other at the short interval, so that the clock offset is soon
// accurate.
constexpr int kFirst = 8;
constexpr std::size_t kMaxUnsent = 64 * 1024;
// Limit of status messages between two frames. Plugging a camera by hand causes a few such
// messages.
constexpr int kMostStatuses = 100;

}  // namespace

class FrameClient::Protocol {
 public:
  /// `encryption` is empty for a connection without encryption.
  Protocol(std::string address, std::optional<tls::Context> encryption)
      : address_(std::move(address)), encryption_(std::move(encryption)) {}

  Result<void> open(std::chrono::milliseconds timeout, const std::stop_token& stop) {
    const auto target = parse_host_port(address_);
    if (!target) return fail(target.error());
    if (const auto found = find(*target, stop); !found) return found;
    connect();
    return run_until([this] { return welcomed_; }, stop, Clock::now() + timeout,
                     " does not answer: is a capture_server running there?");
  }

  Result<ReceivedFrame> receive(const std::stop_token& stop, std::optional<Instant> latest) {
    watch_.resume(Clock::now());
    if (!reading_ && !failure_) read_message();
    const auto arrived =
        run_until([this] { return arrived_.has_value(); }, stop, latest, " sends no pictures");
    watch_.pause(Clock::now());
    if (!arrived) return fail(arrived.error());
    return *std::exchange(arrived_, std::nullopt);
  }

  void request_keyframe() {
    asio::post(io_, [this] { send(encode_keyframe_request()); });
  }

  void on_camera_status(std::function<void(const std::string&)> callback) {
    on_camera_status_ = std::move(callback);
  }

  ClockOffset clock() const { return same_clock_ ? ClockOffset{} : estimate_.at(Clock::now()); }
  const StreamDescription& description() const { return description_; }
  std::uint64_t bytes_received() const { return connection_.bytes_read(); }

 private:
  /// Runs the event loop until `done` returns true. Fails if the connection fails or on a stop
  /// request. Fails after `deadline` with the message `too_late`.
  template <class Done>
  Result<void> run_until(const Done& done, const std::stop_token& stop, std::optional<Instant> deadline,
                         const char* too_late) {
    const std::stop_callback wake(stop, [this] { asio::post(io_, [] {}); });
    io_.restart();
    while (!done()) {
      if (failure_) return fail(*failure_);
      if (stop.stop_requested())
        return fail(ErrorCode::kUnavailable, address_ + ": stopped waiting on request");
      if (!deadline) {
        io_.run_one();
        continue;
      }
      io_.run_one_until(*deadline);
      if (!done() && Clock::now() >= *deadline) return fail(ErrorCode::kTimeout, address_ + too_late);
    }
    return {};
  }

  Result<void> find(const HostPort& target, const std::stop_token& stop) {
    asio::error_code not_numeric;
    const auto numeric = asio::ip::make_address(target.host, not_numeric);
    if (!not_numeric) {
      endpoints_ = {tcp::endpoint(numeric, target.port)};
      return {};
    }
    const NameLookup lookup(io_, target.host, target.port,
                            [this](const asio::error_code& error, std::vector<tcp::endpoint> found) {
                              endpoints_ = std::move(found);
                              if (endpoints_.empty())
                                fail_with(ErrorCode::kNotFound,
                                          fmt::format("no host has this name ({})", error.message()));
                            });
    return run_until([this] { return !endpoints_.empty(); }, stop, {}, "");
  }

  void connect() {
    connection_.connect(endpoints_, [this](const asio::error_code& error) {
      if (error == asio::error::connection_refused) {
        return fail_with(
            ErrorCode::kNotFound,
            "connection refused: start a capture_server there (without --loop it ends with its recording)");
      }
      if (error) return fail_with(ErrorCode::kNotFound, error.message());
      connection_.handshake([this](const asio::error_code& failed) { greet(failed); });
    });
  }

  void greet(const asio::error_code& error) {
    if (failure_) return;
    if (error == TransportError::kWrongKey) {
      return fail_with(
          ErrorCode::kRefused,
          "the server has another room key: give --key FILE with a copy of the server's key file");
    }
    if (error == TransportError::kBroken) return fail_with(ErrorCode::kCorrupt, "a damaged TLS handshake");
    if (error == TransportError::kPeerIsPlain) {
      only_a_reject_ = true;  // Nothing else is believed without encryption.
      return read_message();
    }
    if (error) return lost(error);
    hello_at_ = Clock::now();
    send(encode(Hello{}));
    read_message();
  }

  void read_message() {
    reading_ = true;
    connection_.read({asio::buffer(header_)}, [this](const asio::error_code& error) {
      if (error) return lost(error);
      const auto header = decode_header(header_);
      if (!header) return fail_with(header.error());
      watch_.bytes_came(connection_.last_arrival());
      watch_.message_has(kHeaderBytes + header->body_bytes);
      if (header->type == MessageType::kFrame)
        return welcomed_ ? read_frame(header->body_bytes) : protocol_error();
      body_.resize(header->body_bytes);
      connection_.read({asio::buffer(body_)},
                       [this, type = header->type](const asio::error_code& body_error) {
                         if (body_error) return lost(body_error);
                         message_is_complete();
                         take(type);
                       });
    });
  }

  void read_frame(std::uint32_t body_bytes) {
    connection_.read({asio::buffer(frame_head_)}, [this, body_bytes](const asio::error_code& error) {
      if (error) return lost(error);
      const auto head = decode_frame_head(frame_head_, body_bytes);
      if (!head) return fail_with(head.error());
      read_access_units(*head);
    });
  }

  void read_access_units(const FrameHead& head) {
    ReceivedFrame& frame = incoming_;
    frame.frame.keyframe = head.keyframe;
    frame.frame.sequence = head.sequence;
    frame.frame.durations = head.durations;
    frame.frame.depth.resize(head.depth_bytes);
    frame.frame.color.resize(head.color_bytes);
    frame.counters = head.counters;
    frame.sent_at = head.sent_at;
    connection_.read({asio::buffer(frame.frame.depth), asio::buffer(frame.frame.color)},
                     [this](const asio::error_code& error) {
                       if (error) return lost(error);
                       message_is_complete();
                       incoming_.received_at = connection_.last_arrival();
                       send(encode(FrameAck{incoming_.frame.sequence}));
                       arrived_ = std::exchange(incoming_, {});
                       reading_ = false;  // The next receive() starts a read.
                       statuses_ = 0;
                     });
  }

  void message_is_complete() {
    watch_.message_is_complete();
    bytes_of_messages_ = connection_.bytes_read();
  }

  void take(MessageType type) {
    if (only_a_reject_) {
      if (type != MessageType::kReject) return protocol_error();
      return fail_with(
          ErrorCode::kRefused,
          "the server has no key: start the client without --key, or the server with --key FILE");
    }
    switch (type) {
      case MessageType::kReject:
        return welcomed_ ? protocol_error() : take_reject();
      case MessageType::kWelcome:
        return welcomed_ ? protocol_error() : take_welcome();
      case MessageType::kEndOfStream: {
        auto end = decode_end_of_stream(body_);
        if (!end) return fail_with(end.error());
        return fail_with(ErrorCode::kEndOfStream, std::move(end->reason));
      }
      case MessageType::kCameraStatus: {
        const auto status = decode_camera_status(body_);
        if (!status) return fail_with(status.error());
        if (!welcomed_) return protocol_error();
        if (++statuses_ > kMostStatuses)
          return fail_with(ErrorCode::kCorrupt, "camera statuses and no frames");
        if (on_camera_status_) on_camera_status_(status->text);
        return read_message();
      }
      case MessageType::kPong: {
        const auto pong = decode_pong(body_);
        if (!pong) return fail_with(pong.error());
        if (pong->client_time != ping_at_) return protocol_error();
        learn_clock(*std::exchange(ping_at_, std::nullopt), pong->server_time);
        return read_message();
      }
      default:
        return protocol_error();
    }
  }

  void take_reject() {
    auto reject = decode_reject(body_);
    if (!reject) return fail_with(reject.error());
    fail_with(may_pass(reject->reason) ? ErrorCode::kUnavailable : ErrorCode::kRefused,
              std::move(reject->text));
  }

  void take_welcome() {
    auto welcome = decode_welcome(body_);
    if (!welcome) return fail_with(welcome.error());
    description_ = std::move(welcome->description);
    same_clock_ = welcome->clock_id != 0 && welcome->clock_id == monotonic_clock_id();
    learn_clock(hello_at_, welcome->server_time);
    welcomed_ = true;
    reading_ = false;
    ping_later();
  }

  /// Adds an answer. The kernel's arrival time may be slightly earlier than `asked`.
  void learn_clock(Instant asked, Instant server_time) {
    estimate_.add(asked, server_time, std::max(asked, connection_.last_arrival()));
  }

  void ping_later() {
    timer_.expires_after(pings_ < kFirst ? kFirstPings : kPings);
    timer_.async_wait([this](const asio::error_code& error) {
      if (error) return;
      if (connection_.bytes_read() > bytes_of_messages_) watch_.bytes_came(connection_.last_arrival());
      switch (watch_.at(Clock::now())) {
        case ArrivalWatch::Verdict::kSilent:
          return fail_with(ErrorCode::kTimeout,
                           fmt::format("silent for {} s", ArrivalWatch::kSilence.count()));
        case ArrivalWatch::Verdict::kTooSlow:
          return fail_with(ErrorCode::kTimeout,
                           fmt::format("the path is too slow: less than {:.0f} kbit/s arrive",
                                       8e-3 * ArrivalWatch::kSlowestPath));
        case ArrivalWatch::Verdict::kAlive:
          break;
      }
      if (!ping_at_) {  // Only one ping at a time.
        ++pings_;
        ping_at_ = Clock::now();
        send(encode(Ping{*ping_at_}));
      }
      ping_later();
    });
  }

  /// Queues a message and sends it as soon as the connection can accept it.
  void send(const Bytes& message) {
    if (failure_ || !connection_.is_open()) return;
    unsent_.insert(unsent_.end(), message.begin(), message.end());
    if (unsent_.size() > kMaxUnsent) return fail_with(ErrorCode::kUnavailable, "the server does not listen");
    if (sending_.empty()) write();
  }

  void write() {
    sending_.swap(unsent_);
    connection_.write({asio::buffer(sending_)}, [this](const asio::error_code& error) {
      sending_.clear();
      if (error) return lost(error);
      if (!unsent_.empty()) write();
    });
  }

  void lost(const asio::error_code& error) {
    const bool hung_up = error == asio::error::eof || error == asio::error::connection_reset ||
                         error == asio::error::broken_pipe;
    fail_with(ErrorCode::kUnavailable, hung_up ? "the server hung up" : error.message());
  }
  void protocol_error() { fail_with(ErrorCode::kCorrupt, "a message that is not allowed here"); }
  void fail_with(const Error& error) { fail_with(error.code, error.what); }
  void fail_with(ErrorCode code, std::string what) {
    if (failure_) return;  // Later errors are consequences of the first error.
    if (code == ErrorCode::kCorrupt) what = "this is no capture_server of this release: it sent " + what;
    failure_ = Error{code, code == ErrorCode::kEndOfStream ? std::move(what) : address_ + ": " + what};
    connection_.close();
    timer_.cancel();
  }

  std::string address_;
  std::optional<tls::Context> encryption_;
  std::function<void(const std::string&)> on_camera_status_;
  asio::io_context io_{1};
  Connection connection_{io_, encryption_ ? &*encryption_ : nullptr};
  asio::steady_timer timer_{io_};
  std::optional<Error> failure_;

  std::vector<tcp::endpoint> endpoints_;
  bool only_a_reject_ = false;  // True if this end encrypts and the server does not.
  bool welcomed_ = false, same_clock_ = false;
  StreamDescription description_;
  ClockEstimate estimate_;
  ArrivalWatch watch_;
  std::uint64_t bytes_of_messages_ = 0;  // Bytes of complete messages.
  Instant hello_at_{};
  std::optional<Instant> ping_at_;  // Time of the unanswered ping.
  int pings_ = 0, statuses_ = 0;

  bool reading_ = false;  // True while a read is under way, perhaps since a stopped receive().
  std::array<std::uint8_t, kHeaderBytes> header_;
  std::array<std::uint8_t, kFrameHeadBytes> frame_head_;
  Bytes body_;
  ReceivedFrame incoming_;
  std::optional<ReceivedFrame> arrived_;

  Bytes unsent_, sending_;
};

Result<FrameClient> FrameClient::connect(const std::string& host_port, std::chrono::milliseconds timeout,
                                         std::stop_token stop, const tls::RoomKey* key) {
  std::optional<tls::Context> encryption;
  if (key) {
    auto made = tls::Context::make(tls::Side::kClient, *key);
    if (!made) return fail(made.error());
    encryption = std::move(*made);
  }
  auto protocol = std::make_unique<Protocol>(host_port, std::move(encryption));
  if (const auto open = protocol->open(timeout, stop); !open) return fail(open.error());
  return FrameClient(std::move(protocol));
}

FrameClient::FrameClient(std::unique_ptr<Protocol> protocol) : protocol_(std::move(protocol)) {}
FrameClient::FrameClient(FrameClient&&) noexcept = default;
FrameClient& FrameClient::operator=(FrameClient&&) noexcept = default;
FrameClient::~FrameClient() = default;

const StreamDescription& FrameClient::description() const {
  return protocol_->description();
}

Result<ReceivedFrame> FrameClient::receive(std::stop_token stop, std::optional<Instant> latest) {
  return protocol_->receive(stop, latest);
}

void FrameClient::on_camera_status(std::function<void(const std::string&)> callback) {
  protocol_->on_camera_status(std::move(callback));
}

void FrameClient::request_keyframe() {
  protocol_->request_keyframe();
}

ClockOffset FrameClient::clock() const {
  return protocol_->clock();
}

std::uint64_t FrameClient::bytes_received() const {
  return protocol_->bytes_received();
}

}  // namespace copresence::wire
