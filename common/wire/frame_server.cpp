#include "common/wire/frame_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <asio.hpp>
#include <cassert>
#include <mutex>
#include <optional>
#include <vector>

#include "common/wire/clock_offset.h"
#include "common/wire/flow_control/encoder_demand.h"
#include "common/wire/session.h"
#include "common/wire/transport/acceptor.h"

namespace copresence::wire {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kSweep{250};
constexpr std::chrono::milliseconds kFlush{400};
constexpr std::size_t kMaxOutbound = 8;  // Limit of frames that the wire thread has not distributed.

Duration period_of(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / stream.frames_per_second));
}

}  // namespace

class FrameServer::Loop {
 public:
  Loop(StreamDescription description, std::optional<tls::Context> encryption, LogLine log_line)
      : encryption_(std::move(encryption)), log_line_(std::move(log_line)), demand_(period_of(description)) {
    stream_.description = std::move(description);
    stream_.clock_id = monotonic_clock_id();
    stream_.on_change = [this] { publish(); };
    stream_.admit = [this](Session& session, Stage stage) { return admit(session, stage); };
  }

  Result<void> listen(const ListeningSocket& socket) { return acceptor_.open(socket); }

  void run(const std::stop_token& stop, std::function<void()> alive) {
    alive_ = std::move(alive);
    const std::stop_callback halt(stop, [this] { io_.stop(); });
    acceptor_.run([this](std::unique_ptr<Connection> connection) { add(std::move(connection)); });
    sweep();
    io_.run();
    for (const auto& session : sessions_) session->close(Ending::kServerEnds);
    acceptor_.close();
    publish();
    forget_closed();
  }

  void send(OutboundFrame outbound) {
    std::lock_guard lock(mutex_);
    ++frames_offered_;
    if (outbound_.size() >= kMaxOutbound) {  // The wire thread is stalled; continue with a keyframe.
      overrun_ += outbound_.size();
      outbound_.clear();
    }
    outbound_.push_back(std::move(outbound));
    if (!std::exchange(distributing_, true)) asio::post(io_, [this] { distribute(); });
  }

  bool wants_frames() const {
    std::lock_guard lock(mutex_);
    return demand_.wants_frame(Clock::now());
  }

  bool take_keyframe_request() {
    std::lock_guard lock(mutex_);
    return demand_.take_keyframe_request(Clock::now());
  }

  void set_camera_status(std::string status) {
    asio::post(io_, [this, status = std::move(status)]() mutable {
      stream_.camera_status = std::move(status);
      const Bytes message = encode(CameraStatus{stream_.camera_status});
      for (const auto& session : sessions_) session->send_status(message);
    });
  }

  void end(std::string reason) {
    asio::post(io_, [this, reason = std::move(reason)] { close_gracefully(reason); });
  }

  ServerCounters counters() const {
    std::lock_guard lock(mutex_);
    return {clients_, bytes_sent_, frames_offered_};
  }

 private:
  void add(std::unique_ptr<Connection> connection) {
    const auto session = std::make_shared<Session>(std::move(connection), stream_);
    if (!admit(*session, Stage::kStranger)) return;
    sessions_.push_back(session);
    session->start();
  }

  /// True if `session` may enter `stage`. Closes another session if wire::admit() requires it.
  bool admit(Session& session, Stage stage) {
    forget_closed();
    std::vector<Standing> others;
    std::vector<Session*> sessions;
    for (const auto& other : sessions_) {
      if (other.get() == &session) continue;
      others.push_back(other->standing());
      sessions.push_back(other.get());
    }
    const Instant now = Clock::now();
    // A newcomer that could not become a client is rejected at once.
    if (stage == Stage::kNewcomer && !wire::admit(Stage::kClient, session.network(), others, now).admitted)
      return false;
    const Decision decision = wire::admit(stage, session.network(), others, now);
    if (decision.in_exchange_for) sessions[*decision.in_exchange_for]->close(Ending::kMadeRoom);
    if (decision.admitted && stage == Stage::kClient) {
      log_.joined(session.address(), 1 + count_clients(&session), now);
      write_log(now);
    }
    return decision.admitted;
  }

  std::size_t count_clients(const Session* except = nullptr) const {
    return static_cast<std::size_t>(
        std::count_if(sessions_.begin(), sessions_.end(), [except](const auto& session) {
          return session.get() != except && session->stage() == Stage::kClient && !session->is_closed();
        }));
  }

  void write_log(Instant now) {
    for (const ConnectionLog::Line& line : log_.take(now)) {
      if (log_line_) log_line_(line.text, line.is_warning);
    }
  }

  void sweep() {
    if (alive_) alive_();
    for (const auto& session : sessions_) session->sweep(Clock::now());
    forget_closed();
    write_log(Clock::now());
    publish();  // Updates bytes_sent.
    sweeper_.expires_after(kSweep);
    sweeper_.async_wait([this](const asio::error_code& error) {
      if (!error) sweep();
    });
  }

  void forget_closed() {
    const Instant now = Clock::now();
    const auto closed = std::stable_partition(sessions_.begin(), sessions_.end(),
                                              [](const auto& session) { return !session->is_closed(); });
    for (auto session = closed; session != sessions_.end(); ++session) {
      if ((*session)->stage() == Stage::kClient) {
        log_.left((*session)->address(), (*session)->ending(), now - (*session)->began_at(), count_clients(),
                  now);
      } else {
        log_.ended_early((*session)->network(), (*session)->ending(), now);
      }
    }
    sessions_.erase(closed, sessions_.end());
  }

  void distribute() {
    std::vector<OutboundFrame> frames;
    std::uint64_t overrun = 0;
    {
      std::lock_guard lock(mutex_);
      distributing_ = false;
      frames.swap(outbound_);
      overrun = std::exchange(overrun_, 0);
    }
    if (overrun > 0) {
      for (const auto& session : sessions_) session->skip(overrun);
    }
    for (const OutboundFrame& outbound : frames) {
      const EncodedFrame& frame = *outbound.frame;
      for (const auto& session : sessions_) session->offer(outbound);
      if (frame.keyframe) stream_.keyframe_requested = false;
      std::lock_guard lock(mutex_);
      demand_.sent(frame.keyframe, frame.depth.size() + frame.color.size(), Clock::now());
    }
    publish();
  }

  /// Updates the values that other threads read.
  void publish() {
    EncoderDemand::Clients clients;
    std::size_t streaming = 0;
    bool open = false;
    for (const auto& session : sessions_) {
      open |= !session->is_closed();
      if (!session->is_streaming()) continue;
      ++streaming;
      clients.add(session->window());
    }
    if (ending_ && !open) io_.stop();
    std::lock_guard lock(mutex_);
    demand_.update(clients);
    if (stream_.keyframe_requested) demand_.request_keyframe();
    clients_ = streaming;
    bytes_sent_ = stream_.bytes_sent;
  }

  void close_gracefully(const std::string& reason) {
    if (std::exchange(ending_, true)) return;
    acceptor_.close();
    const Bytes last = encode(EndOfStream{reason});
    for (const auto& session : sessions_) {
      session->is_streaming() ? session->close_gracefully(last, Ending::kServerEnds)
                              : session->close(Ending::kServerEnds);
    }
    publish();
    flush_.expires_after(kFlush);
    flush_.async_wait([this](const asio::error_code&) { io_.stop(); });
  }

  // Used by the wire thread only.
  asio::io_context io_{1};
  const std::optional<tls::Context> encryption_;
  Acceptor acceptor_{io_, encryption_ ? &*encryption_ : nullptr};
  asio::steady_timer sweeper_{io_}, flush_{io_};
  Session::Stream stream_;
  std::vector<std::shared_ptr<Session>> sessions_;
  ConnectionLog log_;
  LogLine log_line_;
  std::function<void()> alive_;
  bool ending_ = false;

  // Used by all threads while they hold mutex_.
  mutable std::mutex mutex_;
  std::vector<OutboundFrame> outbound_;
  bool distributing_ = false;  // True while distribute() is posted to the wire thread.
  std::uint64_t overrun_ = 0, frames_offered_ = 0, bytes_sent_ = 0;
  std::size_t clients_ = 0;
  EncoderDemand demand_;
};

Result<std::unique_ptr<FrameServer>> FrameServer::open(const ListeningSocket& socket,
                                                       StreamDescription description, const tls::RoomKey* key,
                                                       LogLine log_line) {
  if (const auto good = check(description); !good) return fail(good.error());
  std::optional<tls::Context> encryption;
  if (key) {
    auto made = tls::Context::make(tls::Side::kServer, *key);
    if (!made) return fail(made.error());
    encryption = std::move(*made);
  }
  auto loop = std::make_unique<Loop>(std::move(description), std::move(encryption), std::move(log_line));
  if (const auto listening = loop->listen(socket); !listening) return fail(listening.error());
  return std::unique_ptr<FrameServer>(new FrameServer(std::move(loop)));
}

FrameServer::FrameServer(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
FrameServer::~FrameServer() = default;

void FrameServer::run(std::stop_token stop, std::function<void()> alive) {
  loop_->run(stop, std::move(alive));
}

void FrameServer::send(std::shared_ptr<const EncodedFrame> frame, const FrameCounters& counters) {
  assert(frame && frame->sequence > 0 && !frame->depth.empty());
  loop_->send({std::move(frame), counters, Clock::now()});
}

bool FrameServer::wants_frames() const {
  return loop_->wants_frames();
}

bool FrameServer::take_keyframe_request() {
  return loop_->take_keyframe_request();
}

void FrameServer::set_camera_status(std::string status) {
  loop_->set_camera_status(std::move(status));
}

void FrameServer::end(std::string reason) {
  loop_->end(std::move(reason));
}

ServerCounters FrameServer::counters() const {
  return loop_->counters();
}

}  // namespace copresence::wire
