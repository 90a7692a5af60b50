#pragma once

// One connection between a client and a server: bytes in and out, in order. The bytes travel over
// TCP, unencrypted. Sessions and clients read and write only through this class, so encryption
// could be added here without changes to them.
//
// The connection knows when bytes arrived, however late they are read, since the kernel notes when
// it queued each segment (SO_TIMESTAMPNS). So a client that decodes between two reads measures the
// network and not its own decoder. The kernel may merge neighbouring unread segments; their time is
// then that of the last segment. If the kernel gives no time, the time of reading is used.
//
// Callbacks run on the io_context's thread, never inside the call that takes them. After an error
// nothing more can be read or written. close() ends pending reads and writes with an error. Thread:
// the thread that runs the io_context.

#include <array>
#include <asio.hpp>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "common/frame/rgbd_frame.h"

struct msghdr;

namespace copresence::wire {

class Connection {
 public:
  using Done = std::function<void(const asio::error_code&)>;
  static constexpr std::size_t kMostBuffers = 2;

  /// A client's end, not connected yet. `io` must outlive this object.
  explicit Connection(asio::io_context& io) : socket_(io) {}
  /// A server's end of an accepted connection.
  explicit Connection(asio::ip::tcp::socket accepted);

  /// Tries the addresses one after the other.
  void connect(const std::vector<asio::ip::tcp::endpoint>& addresses, Done done);

  /// Fills at most kMostBuffers `buffers`, which must live until `done`. Only one read may be under
  /// way.
  void read(std::initializer_list<asio::mutable_buffer> buffers, Done done);
  /// Writes `buffers`, which must live until `done`. Only one write may be under way.
  void write(const std::vector<asio::const_buffer>& buffers, Done done);
  /// Signals the end of the stream to the peer, after the bytes written so far. Reading continues.
  void end_writing();
  void close();
  bool is_open() const { return socket_.is_open(); }

  /// When the newest byte that was read arrived. This time never decreases and is never in the
  /// future.
  Instant last_arrival() const { return last_arrival_; }
  std::uint64_t bytes_read() const { return bytes_read_; }
  /// Bytes that were written here and that the other end's kernel has not acknowledged.
  int unacknowledged_bytes();

  /// Address of the other end, for example "192.0.2.1:7001" or "[2001:db8::1]:7001". An IPv4
  /// address that was mapped into IPv6 is returned as IPv4.
  std::string peer() const;
  /// Block that one party usually controls: an IPv4 address, or the first 64 bits of IPv6.
  std::string peer_network() const;

 private:
  using Buffers = std::array<asio::mutable_buffer, kMostBuffers>;

  void begin();
  void read_on(Buffers buffers, Done done);
  Instant arrival_of(msghdr& message) const;

  asio::ip::tcp::socket socket_;
  Instant last_arrival_{};
  std::uint64_t bytes_read_ = 0;
};

/// Returns the network of an address as Connection::peer_network() does.
std::string network_of(const asio::ip::address& address);

}  // namespace copresence::wire
