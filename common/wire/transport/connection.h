#pragma once

// One connection between a client and a server, as the protocol sees it: bytes in, bytes out, in
// order.
//
// The bytes travel over TCP, unencrypted. Encryption has its place here: sessions and clients read
// and write through this class only, so they need no change for it.
//
// The connection knows when bytes arrived, however late they are read. The kernel notes when it
// queued each segment (SO_TIMESTAMPNS). A client that decodes between two reads therefore measures
// the network and not its own decoder. The kernel may merge neighbouring segments that nobody has
// read yet; their time is then that of the last one. Where the kernel gives no time, bytes count as
// arrived when they are read.
//
// Callbacks run on the io_context's thread, never from within the call that takes them. After an
// error nothing more can be read or written. close() ends reads and writes that are under way with
// an error. Thread: the one that runs the io_context.

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

  /// A client's end, not connected yet. `io` must outlive this.
  explicit Connection(asio::io_context& io) : socket_(io) {}
  /// A server's end of a connection that was accepted.
  explicit Connection(asio::ip::tcp::socket accepted);

  /// Tries the addresses one after the other.
  void connect(const std::vector<asio::ip::tcp::endpoint>& addresses, Done done);

  /// Fills all `buffers`. The memory must live until `done`. Requires at most kMostBuffers buffers
  /// and no other read under way.
  void read(std::initializer_list<asio::mutable_buffer> buffers, Done done);
  /// Writes all `buffers`. The memory must live until `done`. Requires no other write under way.
  void write(const std::vector<asio::const_buffer>& buffers, Done done);
  /// The other end reads an end of the stream after what was written. Reading goes on.
  void end_writing();
  void close();
  bool is_open() const { return socket_.is_open(); }

  /// When the newest byte that was read arrived. Never decreases and is never in the future.
  Instant last_arrival() const { return last_arrival_; }
  std::uint64_t bytes_read() const { return bytes_read_; }
  /// Bytes that were written here and that the other end's kernel has not acknowledged.
  int unacknowledged_bytes();

  /// The other end: "192.0.2.1:7001", "[2001:db8::1]:7001". An IPv4 address that was mapped into
  /// IPv6 is given as IPv4.
  std::string peer() const;
  /// What one party usually has for itself: an IPv4 address, or the first 64 bits of an IPv6
  /// address.
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

/// The network of an address: see Connection::peer_network().
std::string network_of(const asio::ip::address& address);

}  // namespace copresence::wire
