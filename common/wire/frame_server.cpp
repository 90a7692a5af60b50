#include "common/wire/frame_server.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <asio.hpp>
#include <cassert>
#include <mutex>
#include <optional>
#include <vector>

#include "common/wire/clock_offset.h"
#include "common/wire/session.h"

namespace copresence::wire {
namespace {

using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kBetweenKeyframes{1};
constexpr std::chrono::milliseconds kSweep{250};
constexpr std::chrono::milliseconds kFlush{400};
constexpr std::chrono::milliseconds kAcceptAgain{100};
constexpr std::size_t kMaxConnections = 2 * FrameServer::kMaxClients;  // with those that have not said hello
constexpr std::size_t kMaxDepartures = 8;  // frames that the wire thread has not looked at yet

}  // namespace

class FrameServer::Loop {
 public:
  explicit Loop(StreamDescription description) {
    stream_.description = std::move(description);
    stream_.clock_id = monotonic_clock_id();
    stream_.max_clients = kMaxClients;
    stream_.on_change = [this] { publish(); };
  }

  Result<void> listen(const ListeningSocket& socket) {
    const int descriptor = ::dup(socket.descriptor());
    if (descriptor < 0) return fail(ErrorCode::kUnavailable, "cannot serve the port: too many open files");
    int domain = AF_INET;
    socklen_t size = sizeof domain;
    ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &domain, &size);
    asio::error_code error;
    acceptor_.assign(domain == AF_INET6 ? tcp::v6() : tcp::v4(), descriptor, error);
    if (error) {
      ::close(descriptor);
      return fail(ErrorCode::kUnavailable, fmt::format("cannot serve the port: {}", error.message()));
    }
    return {};
  }

  void run(const std::stop_token& stop, std::function<void()> alive) {
    alive_ = std::move(alive);
    const std::stop_callback halt(stop, [this] { io_.stop(); });
    accept();
    sweep();
    io_.run();
    for (const auto& session : sessions_) session->close();
    sessions_.clear();
    stop_accepting();
    publish();
  }

  void send(Departure departure) {
    std::lock_guard lock(mutex_);
    ++frames_offered_;
    if (departures_.size() >= kMaxDepartures) {  // the wire thread stands still: begin anew at a keyframe
      overrun_ += departures_.size();
      departures_.clear();
    }
    departures_.push_back(std::move(departure));
    if (!std::exchange(distributing_, true)) asio::post(io_, [this] { distribute(); });
  }

  bool wants_frames() const {
    std::lock_guard lock(mutex_);
    return room_in_step_ || (room_at_keyframe_ && (keyframe_promised_ || may_request_keyframe()));
  }

  bool take_keyframe_request() {
    std::lock_guard lock(mutex_);
    if (!keyframe_wanted_ || !may_request_keyframe()) return false;
    keyframe_taken_at_ = Clock::now();
    keyframe_promised_ = true;
    return true;
  }

  void tell(std::string notice) {
    asio::post(io_, [this, notice = std::move(notice)]() mutable {
      stream_.notice = std::move(notice);
      const Bytes message = encode(Notice{stream_.notice});
      for (const auto& session : sessions_) session->tell(message);
    });
  }

  void end(std::string reason) {
    asio::post(io_, [this, reason = std::move(reason)] { say_goodbye(reason); });
  }

  ServerCounters counters() const {
    std::lock_guard lock(mutex_);
    return {clients_, bytes_sent_, frames_offered_};
  }

 private:
  void accept() {
    acceptor_.async_accept([this](const asio::error_code& error, tcp::socket socket) {
      if (ending_ || error == asio::error::operation_aborted) return;
      if (error) {  // out of descriptors, most likely: let some go first
        accept_again_.expires_after(kAcceptAgain);
        return accept_again_.async_wait([this](const asio::error_code&) { accept(); });
      }
      forget_closed();
      if (sessions_.size() < kMaxConnections) {
        sessions_.push_back(std::make_shared<Session>(std::move(socket), stream_));
        sessions_.back()->start();
      }
      accept();
    });
  }

  void stop_accepting() {
    asio::error_code ignored;
    acceptor_.close(ignored);
  }

  void sweep() {
    if (alive_) alive_();
    for (const auto& session : sessions_) session->close_if_overdue(Clock::now());
    forget_closed();
    publish();  // bytes_sent
    sweeper_.expires_after(kSweep);
    sweeper_.async_wait([this](const asio::error_code& error) {
      if (!error) sweep();
    });
  }

  void forget_closed() {
    std::erase_if(sessions_, [](const auto& session) { return session->is_closed(); });
  }

  void distribute() {
    std::vector<Departure> departures;
    std::uint64_t overrun = 0;
    {
      std::lock_guard lock(mutex_);
      distributing_ = false;
      departures.swap(departures_);
      overrun = std::exchange(overrun_, 0);
    }
    if (overrun > 0) {
      for (const auto& session : sessions_) session->skip(overrun);
    }
    for (const Departure& departure : departures) {
      for (const auto& session : sessions_) session->offer(departure);
      if (departure.frame->keyframe) stream_.keyframe_requested = false;
    }
    const bool keyframe = std::any_of(departures.begin(), departures.end(),
                                      [](const Departure& departure) { return departure.frame->keyframe; });
    publish(keyframe);
  }

  /// Brings what other threads may ask for up to date.
  void publish(bool keyframe_sent = false) {
    bool in_step = false, at_keyframe = false;
    bool open = false;
    for (const auto& session : sessions_) {
      open |= !session->is_closed();
      if (!session->is_streaming() || !session->window().has_room()) continue;
      (session->window().in_step() ? in_step : at_keyframe) = true;
    }
    if (ending_ && !open) io_.stop();
    std::lock_guard lock(mutex_);
    room_in_step_ = in_step;
    room_at_keyframe_ = at_keyframe;
    keyframe_wanted_ = at_keyframe || stream_.keyframe_requested;
    if (keyframe_sent) keyframe_promised_ = false;
    clients_ = stream_.clients;
    bytes_sent_ = stream_.bytes_sent;
  }

  void say_goodbye(const std::string& reason) {
    if (std::exchange(ending_, true)) return;
    stop_accepting();
    const Bytes last = encode(EndOfStream{reason});
    for (const auto& session : sessions_) {
      session->is_streaming() ? session->say_goodbye(last) : session->close();
    }
    publish();
    flush_.expires_after(kFlush);
    flush_.async_wait([this](const asio::error_code&) { io_.stop(); });
  }

  /// Call with mutex_ held.
  bool may_request_keyframe() const {
    return !keyframe_taken_at_ || Clock::now() - *keyframe_taken_at_ >= kBetweenKeyframes;
  }

  // The wire thread's.
  asio::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  asio::steady_timer sweeper_{io_}, accept_again_{io_}, flush_{io_};
  Session::Stream stream_;
  std::vector<std::shared_ptr<Session>> sessions_;
  std::function<void()> alive_;
  bool ending_ = false;

  // Everybody's.
  mutable std::mutex mutex_;
  std::vector<Departure> departures_;
  bool distributing_ = false;  // the wire thread has been told of them
  std::uint64_t overrun_ = 0, frames_offered_ = 0, bytes_sent_ = 0;
  std::size_t clients_ = 0;
  bool room_in_step_ = false;      // a client could have the next frame, whatever it is
  bool room_at_keyframe_ = false;  // a client could have it if it is a keyframe
  bool keyframe_wanted_ = false, keyframe_promised_ = false;
  std::optional<Instant> keyframe_taken_at_;
};

Result<std::unique_ptr<FrameServer>> FrameServer::open(const ListeningSocket& socket,
                                                       StreamDescription description) {
  if (const auto good = check(description); !good) return fail(good.error());
  auto loop = std::make_unique<Loop>(std::move(description));
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

void FrameServer::tell(std::string notice) {
  loop_->tell(std::move(notice));
}

void FrameServer::end(std::string reason) {
  loop_->end(std::move(reason));
}

ServerCounters FrameServer::counters() const {
  return loop_->counters();
}

}  // namespace copresence::wire
