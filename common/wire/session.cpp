#include "common/wire/session.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/wire/tcp.h"

namespace copresence::wire {
namespace {

constexpr std::chrono::seconds kHandshakeTime{2};
constexpr std::chrono::seconds kSilence{30};  // a client pings once a second
constexpr std::chrono::seconds kGoodbyeTime{1};

// A keyframe of one camera fits, so that it leaves in one call; what lies here is in the client's window as
// well.
constexpr int kSendBuffer = 256 * 1024;
constexpr std::size_t kMessagesAtOnce = 16;
constexpr std::size_t kMaxQueued = 64 + ClientWindow::kFrames;  // frames, and pongs nobody waits for

Duration frame_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / stream.frames_per_second));
}

}  // namespace

Session::Session(asio::ip::tcp::socket socket, Stream& stream)
    : socket_(std::move(socket)),
      stream_(stream),
      window_(frame_period(stream.description)),
      overdue_at_(std::chrono::steady_clock::now() + kHandshakeTime) {
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
                            if (error) return self->close();
                            self->has_read(bytes);
                          });
}

void Session::has_read(std::size_t bytes) {
  if (phase_ == Phase::kClosed) return;
  in_bytes_ += bytes;
  if (phase_ == Phase::kStreaming) overdue_at_ = std::chrono::steady_clock::now() + kSilence;
  std::span<const std::uint8_t> rest(in_.data(), in_bytes_);
  while (phase_ != Phase::kLeaving && rest.size() >= kHeaderBytes) {
    const auto header = decode_header(rest.first<kHeaderBytes>());
    if (!header || kHeaderBytes + header->body_bytes > in_.size()) return close();
    if (rest.size() < kHeaderBytes + header->body_bytes) break;
    if (!take(*header, rest.subspan(kHeaderBytes, header->body_bytes))) return close();
    if (phase_ == Phase::kClosed) return;
    rest = rest.subspan(kHeaderBytes + header->body_bytes);
  }
  if (phase_ == Phase::kLeaving) rest = {};  // only its end matters now
  std::copy(rest.begin(), rest.end(), in_.begin());
  in_bytes_ = rest.size();
  read();
}

bool Session::take(MessageHeader header, std::span<const std::uint8_t> body) {
  if (phase_ == Phase::kGreeting) return header.type == MessageType::kHello && take_hello(body);
  switch (header.type) {
    case MessageType::kFrameAck: {
      const auto ack = decode_frame_ack(body);
      if (!ack || !window_.acknowledge(ack->sequence, std::chrono::steady_clock::now())) return false;
      stream_.on_change();
      return true;
    }
    case MessageType::kPing: {
      const auto ping = decode_ping(body);
      if (!ping || out_.size() >= kMaxQueued) return false;
      queue({encode(Pong{ping->client_time, std::chrono::steady_clock::now()}), nullptr});
      return true;
    }
    case MessageType::kKeyframeRequest:
      stream_.keyframe_requested = true;
      stream_.on_change();
      return true;
    default:
      return false;
  }
}

bool Session::take_hello(std::span<const std::uint8_t> body) {
  const auto hello = decode_hello(body);
  if (!hello) return false;
  if (hello->version != kProtocolVersion) {
    say_goodbye(
        encode(Refusal{RefusalReason::kVersion,
                       fmt::format("the server speaks protocol version {}, this client {}: install the same "
                                   "release of Copresence on both",
                                   kProtocolVersion, hello->version)}));
  } else if (stream_.clients >= stream_.max_clients) {
    say_goodbye(encode(
        Refusal{RefusalReason::kFull,
                fmt::format("the server has {} clients already, as many as it takes: close one of them",
                            stream_.clients)}));
  } else {
    queue(
        {encode(Welcome{stream_.clock_id, std::chrono::steady_clock::now(), stream_.description}), nullptr});
    if (!stream_.notice.empty()) queue({encode(Notice{stream_.notice}), nullptr});
    enter(Phase::kStreaming);
    overdue_at_ = std::chrono::steady_clock::now() + kSilence;
  }
  return true;
}

void Session::offer(const Departure& departure) {
  if (!is_streaming()) return;
  const EncodedFrame& frame = *departure.frame;
  const std::size_t bytes = kFrameHeadBytes + frame.depth.size() + frame.color.size();
  if (!window_.may_have(frame.keyframe) || bytes > kMaxMessageBytes) return window_.skip(1);

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
  // Who reads nothing needs no news either.
  if (is_streaming() && out_.size() < kMaxQueued) queue({notice, nullptr});
}

void Session::say_goodbye(const Bytes& last) {
  if (phase_ == Phase::kLeaving || phase_ == Phase::kClosed) return;
  enter(Phase::kLeaving);
  overdue_at_ = std::chrono::steady_clock::now() + kGoodbyeTime;
  queue({last, nullptr});
}

void Session::close() {
  if (phase_ == Phase::kClosed) return;
  asio::error_code ignored;
  socket_.close(ignored);
  enter(Phase::kClosed);
}

void Session::close_if_overdue(Instant now) {
  if (now >= overdue_at_) close();
}

void Session::enter(Phase phase) {
  const bool was_streaming = is_streaming();
  phase_ = phase;
  if (was_streaming == is_streaming()) return;
  stream_.clients += is_streaming() ? 1 : -1;
  stream_.on_change();
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
                      if (error) return self->close();
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
