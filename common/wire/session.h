#pragma once

// One connection of a FrameServer: handshake, window, queue of what goes out. Not for other modules: it shows
// Asio.
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

#include "common/frame/coded_frame.h"
#include "common/wire/admission.h"
#include "common/wire/client_window.h"
#include "common/wire/connection_log.h"
#include "common/wire/message_codec.h"

namespace copresence::wire {

/// A frame on its way to every client.
struct OutboundFrame {
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
    bool keyframe_requested =
        false;                     ///< a client has sent a keyframe request since the last keyframe went out
    std::uint64_t bytes_sent = 0;  ///< to all clients
    std::string notice;            ///< what keeps the camera from sending frames; empty: nothing
    std::function<void()> on_change;  ///< a client joined, left, has room again, or wants a keyframe
    /// Asks for the next stage; false where there is no room in it. It may close other sessions.
    std::function<bool(Session&, Stage)> admit;
  };

  Session(asio::ip::tcp::socket socket, Stream& stream);

  void start();
  void offer(const OutboundFrame& departure);  ///< queues the frame if the window allows, counts it otherwise
  void skip(std::uint64_t frames);
  void tell(const Bytes& notice);
  /// The last message; closes when the client has read it, or after a second.
  void close_gracefully(const Bytes& last, Ending why);
  void close(Ending why);
  /// Looks for signs of life; closes a session that showed none in time.
  void sweep(Instant now);

  bool is_streaming() const { return phase_ == Phase::kStreaming; }
  bool is_closed() const { return phase_ == Phase::kClosed; }
  const ClientWindow& window() const { return window_; }

  Standing standing() const { return {network_, stage_, began_at_, window_.waits_since()}; }
  const std::string& network() const { return network_; }
  const std::string& address() const { return address_; }
  Stage stage() const { return stage_; }
  Ending ending() const { return ending_; }  ///< requires is_closed()
  Instant began_at() const { return began_at_; }

 private:
  enum class Phase { kGreeting, kStreaming, kLeaving, kClosed };
  struct Outgoing {
    Bytes head;
    std::shared_ptr<const EncodedFrame> frame;  // null: head is all
  };

  void read();
  void has_read(std::size_t bytes);
  bool take(MessageHeader header, std::span<const std::uint8_t> body);  // false: a protocol error
  bool take_hello(std::span<const std::uint8_t> body);
  bool take_ack(std::span<const std::uint8_t> body);
  void queue(Outgoing message);
  void write();
  void has_written(std::size_t bytes);
  void enter(Phase phase);
  void lives(Instant now);

  asio::ip::tcp::socket socket_;
  Stream& stream_;
  std::string address_, network_;
  ClientWindow window_;
  Phase phase_ = Phase::kGreeting;
  Stage stage_ = Stage::kStranger;
  Ending ending_ = Ending::kHungUp;
  Instant began_at_, overdue_at_;
  int unacknowledged_bytes_ = 0;       // of ours in the kernel, when looked at last
  std::array<std::uint8_t, 1024> in_;  // far more than the largest message of a client
  std::size_t in_bytes_ = 0;
  std::deque<Outgoing> out_;
  std::vector<asio::const_buffer> buffers_;  // of the messages being written: the first writing_ of out_
  std::size_t writing_ = 0;
};

}  // namespace copresence::wire
