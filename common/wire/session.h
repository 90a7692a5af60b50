#pragma once

// One client of a FrameServer: handshake, window, queue of what goes out. Not for other rooms: it shows Asio.
//
// Thread: the wire thread.

#include <array>
#include <asio.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/frame/encoded_frame.h"
#include "common/wire/client_window.h"
#include "common/wire/message_codec.h"

namespace copresence::wire {

/// A frame on its way to every client.
struct Departure {
  std::shared_ptr<const EncodedFrame> frame;
  FrameCounters counters;  ///< window_full: not encoded since no client had room
  Instant sent_at{};
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  /// What sessions share; outlives them.
  struct Stream {
    StreamDescription description;
    std::uint64_t clock_id = 0;
    std::size_t max_clients = 0;
    std::size_t clients = 0;          ///< sessions past their handshake
    bool keyframe_requested = false;  ///< by a client in words, since the last keyframe
    std::uint64_t bytes_sent = 0;     ///< to all clients
    std::string notice;               ///< what keeps the camera from sending frames; empty: nothing
    std::function<void()> on_change;  ///< a client joined, left, has room again, or wants a keyframe
  };

  Session(asio::ip::tcp::socket socket, Stream& stream);

  void start();
  void offer(const Departure& departure);  ///< queues the frame if the window allows, counts it otherwise
  void skip(std::uint64_t frames);
  void tell(const Bytes& notice);
  void say_goodbye(
      const Bytes& last);  ///< nothing follows; closes when the client has read it, or after a second
  void close();
  void close_if_overdue(Instant now);

  bool is_streaming() const { return phase_ == Phase::kStreaming; }
  bool is_closed() const { return phase_ == Phase::kClosed; }
  const ClientWindow& window() const { return window_; }

 private:
  enum class Phase { kGreeting, kStreaming, kLeaving, kClosed };
  struct Outgoing {
    Bytes head;
    std::shared_ptr<const EncodedFrame> frame;  // null: head is all
  };

  void read();
  void has_read(std::size_t bytes);
  bool take(MessageHeader header, std::span<const std::uint8_t> body);  // false: the client talks nonsense
  bool take_hello(std::span<const std::uint8_t> body);
  void queue(Outgoing message);
  void write();
  void has_written(std::size_t bytes);
  void enter(Phase phase);

  asio::ip::tcp::socket socket_;
  Stream& stream_;
  ClientWindow window_;
  Phase phase_ = Phase::kGreeting;
  Instant overdue_at_;
  std::array<std::uint8_t, 1024> in_;  // far more than the largest message of a client
  std::size_t in_bytes_ = 0;
  std::deque<Outgoing> out_;
  std::vector<asio::const_buffer> buffers_;  // of the messages being written: the first writing_ of out_
  std::size_t writing_ = 0;
};

}  // namespace copresence::wire
