#include "common/wire/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace copresence::wire {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kHandshakeTime{2};
constexpr std::chrono::seconds kGoodbyeTime{1};
// A client pings once a second.
constexpr std::chrono::seconds kSilence{30};
// Longest time from queueing a frame to its acknowledgement.
constexpr std::chrono::seconds kFrameTime{60};

// Largest body of a client's message, in bytes. Real messages are much smaller.
constexpr std::size_t kLargestOfClient = 1024;
constexpr std::size_t kMessagesAtOnce = 16;
constexpr std::size_t kMaxQueued = 64 + ClientWindow::kFrames;  // Limit of messages.

Duration frame_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / stream.frames_per_second));
}

}  // namespace

Session::Session(std::unique_ptr<Connection> connection, Stream& stream)
    : connection_(std::move(connection)),
      stream_(stream),
      address_(connection_->peer()),
      network_(connection_->peer_network()),
      window_(frame_period(stream.description)),
      began_at_(Clock::now()),
      overdue_at_(began_at_ + kHandshakeTime) {}

void Session::start() {
  connection_->handshake([self = shared_from_this()](const asio::error_code& error) { self->greet(error); });
}

void Session::greet(const asio::error_code& error) {
  if (phase_ == Phase::kClosed) return;
  if (error == TransportError::kPeerIsPlain) {
    return reject(RejectReason::kKeyNeeded,
                  "this server needs the room's key: give --key FILE with a copy of the server's key file",
                  Ending::kNoKey);
  }
  if (error == TransportError::kPeerIsEncrypted) {
    return reject(RejectReason::kKeyUnexpected,
                  "this server has no key: start the client without --key, or the server with --key FILE",
                  Ending::kUnexpectedKey);
  }
  if (error == TransportError::kWrongKey) return close(Ending::kWrongKey);
  if (error == TransportError::kBroken) return close(Ending::kNonsense);
  if (error) return close(Ending::kHungUp);
  read_header();
}

void Session::reject(RejectReason reason, std::string text, Ending why) {
  close_gracefully(encode(Reject{reason, std::move(text)}), why);
  read_header();
}

void Session::read_header() {
  if (phase_ == Phase::kLeaving) return discard();
  connection_->read({asio::buffer(header_)}, [self = shared_from_this()](const asio::error_code& error) {
    if (error) return self->close(Ending::kHungUp);
    if (self->phase_ == Phase::kLeaving) return self->discard();
    const auto header = decode_header(self->header_);
    if (!header || header->body_bytes > kLargestOfClient) return self->close(Ending::kNonsense);
    self->read_body(*header);
  });
}

void Session::read_body(MessageHeader header) {
  body_.resize(header.body_bytes);
  connection_->read({asio::buffer(body_)},
                    [self = shared_from_this(), header](const asio::error_code& error) {
                      if (error) return self->close(Ending::kHungUp);
                      if (self->phase_ == Phase::kLeaving) return self->discard();
                      if (!self->take(header.type)) return self->close(Ending::kNonsense);
                      if (self->phase_ == Phase::kClosed) return;
                      // Only complete messages prolong the session, so single bytes cannot keep it
                      // open.
                      if (self->phase_ == Phase::kStreaming) self->prolong(Clock::now());
                      self->read_header();
                    });
}

/// Reads and ignores bytes until the client closes the connection. Closing a socket with unread
/// bytes resets the connection, and the client would not get the last message.
void Session::discard() {
  connection_->read({asio::buffer(header_)}, [self = shared_from_this()](const asio::error_code& error) {
    error ? self->close(Ending::kHungUp) : self->discard();
  });
}

bool Session::take(MessageType type) {
  if (phase_ == Phase::kGreeting) return type == MessageType::kHello && take_hello();
  switch (type) {
    case MessageType::kFrameAck:
      return take_ack();
    case MessageType::kPing: {
      const auto ping = decode_ping(body_);
      if (!ping || out_.size() >= kMaxQueued) return false;
      queue({encode(Pong{ping->client_time, Clock::now()}), nullptr});
      return true;
    }
    case MessageType::kKeyframeRequest:
      if (!std::exchange(stream_.keyframe_requested, true)) stream_.on_change();
      return true;
    default:
      return false;
  }
}

bool Session::take_hello() {
  const auto hello = decode_hello(body_);
  if (!hello) return false;
  if (hello->version != kProtocolVersion) {
    close_gracefully(
        encode(Reject{RejectReason::kVersion,
                      fmt::format("the server speaks protocol version {}, this client {}: install the same "
                                  "release of Copresence on both",
                                  kProtocolVersion, hello->version)}),
        Ending::kOtherVersion);
    return true;
  }
  if (!stream_.admit(*this, Stage::kNewcomer)) {
    close_gracefully(
        encode(Reject{RejectReason::kFull,
                      fmt::format("the server has {} clients already, as many as it takes: close one of them",
                                  room_for(Stage::kClient))}),
        Ending::kNoPlace);
    return true;
  }
  stage_ = Stage::kNewcomer;
  queue({encode(Welcome{stream_.clock_id, Clock::now(), stream_.description}), nullptr});
  if (!stream_.camera_status.empty()) queue({encode(CameraStatus{stream_.camera_status}), nullptr});
  prolong(Clock::now());
  enter(Phase::kStreaming);
  return true;
}

bool Session::take_ack() {
  const auto ack = decode_frame_ack(body_);
  if (!ack || !window_.acknowledge(ack->sequence, Clock::now())) return false;
  if (stage_ == Stage::kNewcomer) {
    if (!stream_.admit(*this, Stage::kClient)) {
      close(Ending::kNoPlace);  // The client will connect again and get a Reject.
      return true;
    }
    stage_ = Stage::kClient;
  }
  stream_.on_change();
  return true;
}

void Session::offer(const OutboundFrame& outbound) {
  if (!is_streaming()) return;
  const EncodedFrame& frame = *outbound.frame;
  const std::size_t bytes = kFrameHeadBytes + frame.depth.size() + frame.color.size();
  if (!window_.can_accept(frame.keyframe, Clock::now()) || bytes > kMaxMessageBytes) {
    return window_.skip(1);
  }

  FrameHead head;
  head.keyframe = frame.keyframe;
  head.sequence = frame.sequence;
  head.sent_at = outbound.sent_at;
  head.counters = outbound.counters;
  head.counters.window_full += window_.skipped();
  head.durations = frame.durations;
  head.depth_bytes = static_cast<std::uint32_t>(frame.depth.size());
  head.color_bytes = static_cast<std::uint32_t>(frame.color.size());
  const FrameHeadMessage message = encode(head);
  window_.sent(frame.sequence, bytes, outbound.sent_at);
  queue({Bytes(message.begin(), message.end()), outbound.frame});
}

void Session::skip(std::uint64_t frames) {
  if (is_streaming()) window_.skip(frames);
}

void Session::send_status(const Bytes& message) {
  // If the queue is full, the client reads nothing and does not need the status.
  if (is_streaming() && out_.size() < kMaxQueued) queue({message, nullptr});
}

void Session::close_gracefully(const Bytes& last, Ending why) {
  if (phase_ == Phase::kLeaving || phase_ == Phase::kClosed) return;
  ending_ = why;
  enter(Phase::kLeaving);
  overdue_at_ = Clock::now() + kGoodbyeTime;
  queue({last, nullptr});
}

void Session::close(Ending why) {
  if (phase_ == Phase::kClosed) return;
  if (phase_ != Phase::kLeaving) ending_ = why;
  connection_->close();
  enter(Phase::kClosed);
}

void Session::sweep(Instant now) {
  if (phase_ == Phase::kClosed) return;
  // A large frame on a slow path delays the answers to pings, but its bytes arrive.
  const int before = std::exchange(unacknowledged_bytes_, connection_->unacknowledged_bytes());
  if (phase_ == Phase::kStreaming && unacknowledged_bytes_ < before) prolong(now);
  if (now >= overdue_at_) return close(phase_ == Phase::kGreeting ? Ending::kNoHello : Ending::kSilent);
  const auto waits_since = window_.waits_since();
  if (waits_since && now - *waits_since >= kFrameTime) close(Ending::kNoProgress);
}

void Session::prolong(Instant now) {
  overdue_at_ = now + kSilence;
}

void Session::enter(Phase phase) {
  const bool was_streaming = is_streaming();
  phase_ = phase;
  if (was_streaming != is_streaming()) stream_.on_change();
}

void Session::queue(Outgoing message) {
  out_.push_back(std::move(message));
  write();
}

void Session::write() {
  if (writing_ > 0 || out_.empty() || phase_ == Phase::kClosed) return;
  writing_ = std::min(out_.size(), kMessagesAtOnce);
  buffers_.clear();
  for (std::size_t i = 0; i < writing_; ++i) {
    buffers_.push_back(asio::buffer(out_[i].head));
    if (!out_[i].frame) continue;
    buffers_.push_back(asio::buffer(out_[i].frame->depth));
    buffers_.push_back(asio::buffer(out_[i].frame->color));
  }
  connection_->write(buffers_, [self = shared_from_this()](const asio::error_code& error) {
    error ? self->close(Ending::kHungUp) : self->on_written();
  });
}

void Session::on_written() {
  stream_.bytes_sent += asio::buffer_size(buffers_);
  out_.erase(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(writing_));
  writing_ = 0;
  if (phase_ == Phase::kLeaving && out_.empty()) return connection_->end_writing();
  write();
}

}  // namespace copresence::wire
