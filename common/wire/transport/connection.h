#pragma once

// One connection between a client and a server: bytes in and out, in order, over TCP. With a TLS
// context the bytes are encrypted. Sessions and clients read and write only through this class, and
// need not know which of both it is.
//
// Callbacks run on the io_context's thread, never inside the call that takes them. After an error
// nothing more can be read or written, with one exception: see handshake(). close() ends pending
// reads and writes with an error. Thread: the thread that runs the io_context.

#include <array>
#include <asio.hpp>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "common/tls/session.h"
#include "common/wire/transport/timed_socket.h"
#include "common/wire/transport/transport_error.h"

namespace copresence::wire {

class Connection : private tls::Carrier {
 public:
  using Done = std::function<void(const asio::error_code&)>;
  static constexpr std::size_t kMostBuffers = 2;

  /// A client's end, not connected yet. `encryption` is null for a connection without encryption.
  /// `io` and `encryption` must outlive this object.
  Connection(asio::io_context& io, const tls::Context* encryption) : socket_(io), encryption_(encryption) {}
  /// A server's end of an accepted connection.
  Connection(asio::ip::tcp::socket accepted, const tls::Context* encryption)
      : socket_(std::move(accepted)), encryption_(encryption) {}
  ~Connection() override = default;
  Connection(const Connection&) = delete;  // Handlers and the TLS session refer to it.
  Connection& operator=(const Connection&) = delete;

  /// Connects a client's end: tries the addresses one after the other.
  void connect(const std::vector<asio::ip::tcp::endpoint>& addresses, Done done);

  /// Must come before the first read or write. Makes sure that both ends encrypt with the same room
  /// key, or that neither encrypts. Fails with a TransportError otherwise. After kPeerIsPlain and
  /// kPeerIsEncrypted, reading and writing go on without encryption, for a last message that says
  /// why the connection ends.
  ///
  /// A server's end allocates nothing for a peer before its first message has arrived whole.
  void handshake(Done done);

  /// Fills at most kMostBuffers `buffers`, which must live until `done`. Only one read may be under
  /// way.
  void read(std::initializer_list<asio::mutable_buffer> buffers, Done done);
  /// Writes `buffers`, whose bytes must live until `done`. Only one write may be under way.
  void write(const std::vector<asio::const_buffer>& buffers, Done done);
  /// Signals the end of the stream to the peer, after the bytes written so far. Reading continues.
  void end_writing();
  void close();
  bool is_open() const { return socket_.asio().is_open(); }

  /// When the newest byte that was read arrived (timed_socket.h).
  Instant last_arrival() const { return socket_.last_arrival(); }
  /// Bytes that have come over the network.
  std::uint64_t bytes_read() const { return socket_.bytes_received(); }
  /// Bytes that were written here and that the other end's kernel has not acknowledged.
  int unacknowledged_bytes() { return socket_.unacknowledged_bytes(); }

  /// Address of the other end, for example "192.0.2.1:7001" or "[2001:db8::1]:7001". An IPv4
  /// address that was mapped into IPv6 is returned as IPv4.
  std::string peer() const;
  /// Block that one party usually controls: an IPv4 address, or the first 64 bits of IPv6.
  std::string peer_network() const;

 private:
  using Buffers = std::array<asio::mutable_buffer, kMostBuffers>;
  using Wait = asio::socket_base::wait_type;
  /// What a step has done: moved bytes, or found that it must wait, or failed.
  struct Step {
    std::size_t bytes = 0;
    std::optional<Wait> wait;
    asio::error_code error;
  };

  std::ptrdiff_t receive(std::span<std::uint8_t> to) override;
  std::ptrdiff_t send(std::span<const std::uint8_t> from) override;

  void await_opening(std::size_t bytes, Done done);
  void judge_opening(Done done);
  void shake_hands(Done done);
  void read_on(Buffers buffers, Done done);
  void write_on(Done done);
  Step receive_some(Buffers& buffers);
  Step send_some(asio::const_buffer bytes);
  Step step_of(tls::Outcome outcome, std::size_t bytes);
  template <class Continue>
  void wait(Wait what, Done done, Continue go_on);
  void finish(Done done, const asio::error_code& error);

  TimedSocket socket_;
  const tls::Context* encryption_;
  bool is_client_ = false;
  std::optional<tls::Session> tls_;  // Empty without encryption, and before the handshake.
  bool peer_is_plain_ = false;       // Whether the server's first byte was not one of TLS.
  int carrier_error_ = 0;            // The errno of the last failure of receive() or send().
  // What write_on() has not written yet.
  std::vector<asio::const_buffer> unwritten_;
  std::size_t next_unwritten_ = 0;
  bool more_follows_ = false;
};

/// Returns the network of an address as Connection::peer_network() does.
std::string network_of(const asio::ip::address& address);

}  // namespace copresence::wire
