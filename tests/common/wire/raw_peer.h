#pragma once

// The other end as a bare socket, for what no well-behaved one says.

#include <asio.hpp>
#include <optional>
#include <string>

#include "common/wire/host_port.h"
#include "common/wire/message_codec.h"

namespace copresence::wire {

class RawPeer {
 public:
  /// A client of a server at HOST:PORT.
  explicit RawPeer(const std::string& address) {
    const HostPort to = *parse_host_port(address);
    socket_.connect({asio::ip::make_address(to.host), to.port});
  }
  /// A server's end of the next connection to `acceptor`.
  explicit RawPeer(asio::ip::tcp::acceptor& acceptor) { acceptor.accept(socket_); }

  void say(const Bytes& bytes) { asio::write(socket_, asio::buffer(bytes), ignored_); }
  void say(std::string_view text) { asio::write(socket_, asio::buffer(text), ignored_); }

  /// The next message, header and body; nothing if the other end hung up.
  std::optional<Bytes> hear() {
    Bytes message(kHeaderBytes);
    asio::error_code error;
    asio::read(socket_, asio::buffer(message), error);
    if (error) return {};
    const auto header = decode_header(std::span(message).first<kHeaderBytes>());
    if (!header) return {};
    message.resize(kHeaderBytes + header->body_bytes);
    asio::read(socket_, asio::buffer(message.data() + kHeaderBytes, header->body_bytes), error);
    if (error) return {};
    return message;
  }

  /// The next byte; -1 if the other end hung up.
  int hear_byte() {
    std::uint8_t byte = 0;
    asio::error_code error;
    asio::read(socket_, asio::buffer(&byte, 1), error);
    return error ? -1 : byte;
  }

  /// Hears until the other end hangs up.
  void hear_out() {
    while (hear()) continue;
  }

  /// Vanishes as a killed process does: with data unread, so that the connection is reset.
  void vanish() {
    socket_.set_option(asio::socket_base::linger(true, 0), ignored_);
    socket_.close(ignored_);
  }

 private:
  asio::io_context io_;
  asio::ip::tcp::socket socket_{io_};
  asio::error_code ignored_;
};

inline MessageType type_of(const Bytes& message) {
  return decode_header(std::span(message).first<kHeaderBytes>())->type;
}

inline std::span<const std::uint8_t> body_of(const Bytes& message) {
  return std::span(message).subspan(kHeaderBytes);
}

}  // namespace copresence::wire
