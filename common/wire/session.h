#pragma once

// A FrameServer's connection to one client: handshake, window and the queue of messages to the
// client. Private to this module. Thread: the wire thread.

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/frame/coded_frame.h"
#include "common/wire/connection_log.h"
#include "common/wire/flow_control/admission.h"
#include "common/wire/flow_control/client_window.h"
#include "common/wire/message_codec.h"
#include "common/wire/transport/connection.h"

namespace copresence::wire {

/// A frame that is sent to every client.
struct OutboundFrame {
  std::shared_ptr<const EncodedFrame> frame;
  FrameCounters counters;  ///< Here window_full counts frames that no client requested.
  Instant sent_at{};
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  /// State that all sessions share. It must outlive them.
  struct Stream {
    StreamDescription description;
    std::uint64_t clock_id = 0;
    /// True if a client has requested a keyframe since the last keyframe was sent.
    bool keyframe_requested = false;
    std::uint64_t bytes_sent = 0;  ///< Bytes sent to all clients.
    /// The reason why the camera sends no frames. Empty while it works.
    std::string camera_status;
    /// Called when a client joined, left, can accept frames again, or requested a keyframe.
    std::function<void()> on_change;
    /// Returns true if a session may enter a stage. May close other sessions.
    std::function<bool(Session&, Stage)> admit;
  };

  Session(std::unique_ptr<Connection> connection, Stream& stream);

  void start();
  /// Queues the frame if the client can accept it. Otherwise counts the frame as skipped.
  void offer(const OutboundFrame& frame);
  void skip(std::uint64_t frames);
  void send_status(const Bytes& message);
  /// Sends the last message and closes when the client has read it, or after a second.
  void close_gracefully(const Bytes& last, Ending why);
  void close(Ending why);
  /// Closes a session that has been silent for too long. Call this a few times a second.
  void sweep(Instant now);

  bool is_streaming() const { return phase_ == Phase::kStreaming; }
  bool is_closed() const { return phase_ == Phase::kClosed; }
  const ClientWindow& window() const { return window_; }

  Standing standing() const { return {network_, stage_, began_at_, window_.waits_since()}; }
  const std::string& network() const { return network_; }
  const std::string& address() const { return address_; }
  Stage stage() const { return stage_; }
  Ending ending() const { return ending_; }  ///< Requires is_closed().
  Instant began_at() const { return began_at_; }

 private:
  enum class Phase { kGreeting, kStreaming, kLeaving, kClosed };
  struct Outgoing {
    Bytes head;
    std::shared_ptr<const EncodedFrame> frame;  // If null, the message has only a head.
  };

  void greet(const asio::error_code& error);
  void reject(RejectReason reason, std::string text, Ending why);
  void read_header();
  void read_body(MessageHeader header);
  void discard();
  bool take(MessageType type);  // Returns false on a protocol error.
  bool take_hello();
  bool take_ack();
  void queue(Outgoing message);
  void write();
  void on_written();
  void enter(Phase phase);
  void prolong(Instant now);

  std::unique_ptr<Connection> connection_;
  Stream& stream_;
  std::string address_, network_;
  ClientWindow window_;
  Phase phase_ = Phase::kGreeting;
  Stage stage_ = Stage::kStranger;
  Ending ending_ = Ending::kHungUp;
  Instant began_at_, overdue_at_;
  int unacknowledged_bytes_ = 0;  // Unacknowledged bytes at the last sweep().
  std::array<std::uint8_t, kHeaderBytes> header_;
  Bytes body_;
  std::deque<Outgoing> out_;
  std::vector<asio::const_buffer> buffers_;  // Buffers of the first `writing_` messages of out_.
  std::size_t writing_ = 0;
};

}  // namespace copresence::wire
