#pragma once

// A TCP socket that says when bytes arrived, however late they are read: the kernel notes when it
// queued each segment (SO_TIMESTAMPNS). So a client that decodes between two reads measures the
// network and not its own decoder. The kernel may merge neighbouring unread segments; their time is
// then that of the last segment. If the kernel gives no time, the time of reading is used.
//
// receive() and send() never block. Thread: the thread that runs the io_context.

#include <sys/types.h>
#include <sys/uio.h>

#include <asio.hpp>
#include <cstdint>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"

struct msghdr;

namespace copresence::wire {

class TimedSocket {
 public:
  /// A client's socket, not connected yet. `io` must outlive this object.
  explicit TimedSocket(asio::io_context& io) : socket_(io) {}
  /// A server's end of an accepted connection.
  explicit TimedSocket(asio::ip::tcp::socket accepted);

  /// Sets options that send small messages at once and detect a vanished peer within about 10 s.
  /// Call it once a client's socket is connected.
  void begin();

  /// Receives into the buffers in their order. Returns the number of bytes, 0 at the end of the
  /// stream, or -1 with the reason in errno: EAGAIN if there is nothing to receive.
  ssize_t receive(std::span<iovec> buffers);
  /// Sends a part of the bytes. Returns their number, or -1 with the reason in errno: EAGAIN if the
  /// kernel's buffer is full. With `more_follows`, the kernel may wait for more bytes and fill a
  /// segment.
  ssize_t send(std::span<const std::uint8_t> bytes, bool more_follows);
  /// Copies the first received bytes without taking them. Returns their number; fewer than `bytes`
  /// has may follow.
  std::size_t peek(std::span<std::uint8_t> bytes);
  /// Makes an asynchronous wait for reading end only when so many bytes have arrived.
  void wait_for_bytes(std::size_t bytes);
  /// True if the peer will send nothing more.
  bool has_peer_ended();

  /// When the newest byte that was read arrived. This time never decreases and is never in the
  /// future.
  Instant last_arrival() const { return last_arrival_; }
  std::uint64_t bytes_received() const { return bytes_received_; }
  /// Bytes that were sent and that the other end's kernel has not acknowledged.
  int unacknowledged_bytes();

  asio::ip::tcp::socket& asio() { return socket_; }
  const asio::ip::tcp::socket& asio() const { return socket_; }

 private:
  Instant arrival_of(msghdr& message) const;

  asio::ip::tcp::socket socket_;
  Instant last_arrival_{};
  std::uint64_t bytes_received_ = 0;
};

}  // namespace copresence::wire
