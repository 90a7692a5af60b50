#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/wire/frame_client.h"
#include "common/wire/frame_server.h"
#include "tests/common/wire/sample_messages.h"

namespace copresence::wire {

/// Waits for what another thread is about to make true; at most five seconds.
template <class Condition>
bool eventually(const Condition& condition) {
  for (int i = 0; i < 5000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// A server on a free port of this machine with its wire thread, and a camera that captures when told.
class Served {
 public:
  explicit Served(const tls::RoomKey* key = nullptr)
      : Served(*listen("127.0.0.1:0", Reach::kThisMachine), key) {}
  explicit Served(const ListeningSocket& socket, const tls::RoomKey* key = nullptr)
      : address_(socket.address()),
        server_(*FrameServer::open(socket, sample_description(), key, [this](const std::string& line, bool) {
          const std::lock_guard lock(log_mutex_);
          log_.push_back(line);
        })) {
    wire_ = std::jthread([this](std::stop_token stop) {
      server_->run(stop);
      done_ = true;
    });
  }

  FrameServer& server() { return *server_; }
  const std::string& address() const { return address_; }
  bool is_done() const { return done_; }  ///< run() returned

  Result<FrameClient> client(const tls::RoomKey* key = nullptr) const {
    return FrameClient::connect(address_, std::chrono::seconds(5), {}, key);
  }

  /// One frame as a pipeline makes it: encoded only if wanted. Its sequence number, or 0 if it was not.
  std::uint64_t capture(std::size_t depth_bytes = 1000) {
    ++counters_.captured;
    if (!server_->wants_frames()) {
      ++counters_.window_full;
      return 0;
    }
    auto frame = std::make_shared<EncodedFrame>();
    frame->keyframe = server_->take_keyframe_request();
    frame->sequence = counters_.captured;
    frame->depth.assign(depth_bytes, static_cast<std::uint8_t>(frame->sequence));
    frame->color.assign(depth_bytes / 2, 0x55);
    server_->send(frame, counters_);
    sent_.push_back(frame);
    return frame->sequence;
  }

  /// The same, when somebody wants it. 0 if nobody does within five seconds.
  std::uint64_t capture_when_wanted(std::size_t depth_bytes = 1000) {
    return eventually([this] { return server_->wants_frames(); }) ? capture(depth_bytes) : 0;
  }

  /// What the server said in its log.
  std::vector<std::string> log() const {
    const std::lock_guard lock(log_mutex_);
    return log_;
  }

  /// Encoded frames that the server still holds.
  long frames_held() const {
    return std::count_if(sent_.begin(), sent_.end(), [](const auto& frame) { return !frame.expired(); });
  }

 private:
  mutable std::mutex log_mutex_;
  std::vector<std::string> log_;
  std::string address_;
  std::unique_ptr<FrameServer> server_;
  FrameCounters counters_;
  std::vector<std::weak_ptr<const EncodedFrame>> sent_;
  std::atomic<bool> done_ = false;
  std::jthread wire_;
};

}  // namespace copresence::wire
