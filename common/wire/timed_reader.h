#pragma once

// Reads from a TCP socket and knows when the bytes arrived, however late they are read. Private to this
// module: it shows Asio.
//
// The kernel notes when it queued each segment (SO_TIMESTAMPNS). A client that decodes between two reads so
// measures the network and not its own decoder. The kernel may merge neighbouring segments that nobody has
// read yet; their time is then that of the last one. Where the kernel gives no time, bytes count as arrived
// when they are read.
//
// Thread: the one that runs the socket's io_context.

#include <array>
#include <asio.hpp>
#include <cstdint>
#include <functional>
#include <initializer_list>

#include "common/frame/rgbd_frame.h"

struct msghdr;

namespace copresence::wire {

class TimedReader {
 public:
  using Done = std::function<void(const asio::error_code&)>;
  static constexpr std::size_t kMostBuffers = 2;

  /// `socket` must outlive this.
  explicit TimedReader(asio::ip::tcp::socket& socket) : socket_(socket) {}

  /// Call once the socket is connected: no byte can have arrived before now.
  void start();

  /// Fills all `buffers` and then calls `done` from the io_context, never from within this call. The memory
  /// must live until then. Requires at most kMostBuffers buffers and no other read under way.
  void read(std::initializer_list<asio::mutable_buffer> buffers, Done done);

  /// When the newest byte that was read arrived. Never decreases and is never in the future.
  Instant last_arrival() const { return last_arrival_; }
  std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  void go_on();
  void finish(const asio::error_code& error);
  void skip(std::size_t bytes);
  Instant arrival_of(msghdr& message) const;

  asio::ip::tcp::socket& socket_;
  std::array<asio::mutable_buffer, kMostBuffers> buffers_;
  Done done_;
  Instant last_arrival_{};
  std::uint64_t bytes_read_ = 0;
};

}  // namespace copresence::wire
