#include "common/wire/session.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/wire/tcp.h"

namespace copresence::wire {
namespace {

constexpr std::chrono::seconds kHandshakeTime{2};
constexpr std::chrono::seconds kSilence{30};  // a client pings once a second
constexpr std::chrono::seconds kFrameTime{
    60};  // from queueing a frame to its acknowledgement, on the slowest path
constexpr std::chrono::seconds kGoodbyeTime{1};

// A keyframe of one camera fits, so that it leaves in one call; what lies here is in the client's window as
// well.
constexpr int kSendBuffer = 256 * 1024;
constexpr std::size_t kMessagesAtOnce = 16;
constexpr std::size_t kMaxQueued = 64 + ClientWindow::kFrames;  // frames, and pongs nobody waits for

Duration frame_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / stream.frames_per_second));
}

asio::ip::address address_of(const asio::ip::tcp::socket& socket) {
  asio::error_code error;
  const auto address = socket.remote_endpoint(error).address();
  if (!error && address.is_v6() && address.to_v6().is_v4_mapped()) {
    return asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return address;
}

std::string endpoint_of(const asio::ip::tcp::socket& socket) {
  asio::error_code error;
  const auto address = address_of(socket);
  return fmt::format(fmt::runtime(address.is_v6() ? "[{}]:{}" : "{}:{}"), address.to_string(),
                     socket.remote_endpoint(error).port());
}

}  // namespace

Session::Session(asio::ip::tcp::socket socket, Stream& stream)
    : socket_(std::move(socket)),
      stream_(stream),
      address_(endpoint_of(socket_)),
      network_(network_of(address_of(socket_).to_string())),
      window_(frame_period(stream.description)),
      began_at_(std::chrono::steady_clock::now()),
      overdue_at_(began_at_ + kHandshakeTime) {
  asio::error_code ignored;
  socket_.non_blocking(true, ignored);
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  tune(socket_);
}

void Session::start() {
  read();
}

void Session::read() {
  socket_.async_read_some(asio::buffer(in_.data() + in_bytes_, in_.size() - in_bytes_),
                          [self = shared_from_this()](const asio::error_code& error, std::size_t bytes) {
                            if (error) return self->close(Ending::kHungUp);
                            self->has_read(bytes);
                          });
}

void Session::has_read(std::size_t bytes) {
  if (phase_ == Phase::kClosed) return;
  in_bytes_ += bytes;
  std::span<const std::uint8_t> rest(in_.data(), in_bytes_);
  while (phase_ != Phase::kLeaving && rest.size() >= kHeaderBytes) {
    const auto header = decode_header(rest.first<kHeaderBytes>());
    if (!header || kHeaderBytes + header->body_bytes > in_.size()) return close(Ending::kNonsense);
    if (rest.size() < kHeaderBytes + header->body_bytes) break;
    if (!take(*header, rest.subspan(kHeaderBytes, header->body_bytes))) return close(Ending::kNonsense);
    if (phase_ == Phase::kClosed) return;
    // Only whole messages prove life: their bytes could come one by one for ever.
    if (phase_ == Phase::kStreaming) lives(std::chrono::steady_clock::now());
    rest = rest.subspan(kHeaderBytes + header->body_bytes);
  }
  if (phase_ == Phase::kLeaving) rest = {};  // discard what comes until the end of the connection
  std::copy(rest.begin(), rest.end(), in_.begin());
  in_bytes_ = rest.size();
  read();
}

bool Session::take(MessageHeader header, std::span<const std::uint8_t> body) {
  if (phase_ == Phase::kGreeting) return header.type == MessageType::kHello && take_hello(body);
  switch (header.type) {
    case MessageType::kFrameAck:
      return take_ack(body);
    case MessageType::kPing: {
      const auto ping = decode_ping(body);
      if (!ping || out_.size() >= kMaxQueued) return false;
      queue({encode(Pong{ping->client_time, std::chrono::steady_clock::now()}), nullptr});
      return true;
    }
    case MessageType::kKeyframeRequest:
      if (!std::exchange(stream_.keyframe_requested, true)) stream_.on_change();
      return true;
    default:
      return false;
  }
}

bool Session::take_hello(std::span<const std::uint8_t> body) {
  const auto hello = decode_hello(body);
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
  queue({encode(Welcome{stream_.clock_id, std::chrono::steady_clock::now(), stream_.description}), nullptr});
  if (!stream_.notice.empty()) queue({encode(CameraStatus{stream_.notice}), nullptr});
  lives(std::chrono::steady_clock::now());
  enter(Phase::kStreaming);
  return true;
}

bool Session::take_ack(std::span<const std::uint8_t> body) {
  const auto ack = decode_frame_ack(body);
  if (!ack || !window_.acknowledge(ack->sequence, std::chrono::steady_clock::now())) return false;
  if (stage_ == Stage::kNewcomer) {
    if (!stream_.admit(*this, Stage::kClient)) {
      close(Ending::kNoPlace);  // it connects anew, and is told then
      return true;
    }
    stage_ = Stage::kClient;
  }
  stream_.on_change();
  return true;
}

void Session::offer(const OutboundFrame& departure) {
  if (!is_streaming()) return;
  const EncodedFrame& frame = *departure.frame;
  const std::size_t bytes = kFrameHeadBytes + frame.depth.size() + frame.color.size();
  if (!window_.may_have(frame.keyframe, std::chrono::steady_clock::now()) || bytes > kMaxMessageBytes) {
    return window_.skip(1);
  }

  FrameHead head;
  head.keyframe = frame.keyframe;
  head.sequence = frame.sequence;
  head.sent_at = departure.sent_at;
  head.counters = departure.counters;
  head.counters.window_full += window_.skipped();
  head.durations = frame.durations;
  head.depth_bytes = static_cast<std::uint32_t>(frame.depth.size());
  head.color_bytes = static_cast<std::uint32_t>(frame.color.size());
  const FrameHeadMessage message = encode(head);
  window_.sent(frame.sequence, bytes, departure.sent_at);
  queue({Bytes(message.begin(), message.end()), departure.frame});
}

void Session::skip(std::uint64_t frames) {
  if (is_streaming()) window_.skip(frames);
}

void Session::tell(const Bytes& notice) {
  // A client that reads nothing needs no notices.
  if (is_streaming() && out_.size() < kMaxQueued) queue({notice, nullptr});
}

void Session::close_gracefully(const Bytes& last, Ending why) {
  if (phase_ == Phase::kLeaving || phase_ == Phase::kClosed) return;
  ending_ = why;
  enter(Phase::kLeaving);
  overdue_at_ = std::chrono::steady_clock::now() + kGoodbyeTime;
  queue({last, nullptr});
}

void Session::close(Ending why) {
  if (phase_ == Phase::kClosed) return;
  if (phase_ != Phase::kLeaving) ending_ = why;
  asio::error_code ignored;
  socket_.close(ignored);
  enter(Phase::kClosed);
}

void Session::sweep(Instant now) {
  if (phase_ == Phase::kClosed) return;
  // A large frame on a slow path holds up the answers to pings, but its bytes arrive.
  const int before = std::exchange(unacknowledged_bytes_, unacknowledged_bytes(socket_));
  if (phase_ == Phase::kStreaming && unacknowledged_bytes_ < before) lives(now);
  if (now >= overdue_at_) return close(phase_ == Phase::kGreeting ? Ending::kNoHello : Ending::kSilent);
  const auto waits_since = window_.waits_since();
  if (waits_since && now - *waits_since >= kFrameTime) close(Ending::kNoProgress);
}

void Session::lives(Instant now) {
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
  asio::async_write(socket_, buffers_, kWhole,
                    [self = shared_from_this()](const asio::error_code& error, std::size_t bytes) {
                      if (error) return self->close(Ending::kHungUp);
                      self->has_written(bytes);
                    });
}

void Session::has_written(std::size_t bytes) {
  stream_.bytes_sent += bytes;
  out_.erase(out_.begin(), out_.begin() + static_cast<std::ptrdiff_t>(writing_));
  writing_ = 0;
  if (phase_ == Phase::kLeaving && out_.empty()) {
    // Closing now, with bytes of the client unread, would reset the connection and lose our last words: say
    // that nothing follows and wait until the client hangs up.
    asio::error_code ignored;
    socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    return;
  }
  write();
}

}  // namespace copresence::wire
