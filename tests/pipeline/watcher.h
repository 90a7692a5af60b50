#pragma once

// A viewer without a picture, for tests of servers that fail.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "common/wire/frame_client.h"

namespace copresence::testing {

/// Stays connected as render_client does and notes what comes.
class Watcher {
 public:
  explicit Watcher(std::string address)
      : address_(std::move(address)), thread_([this](std::stop_token stop) { watch(stop); }) {}

  std::uint64_t frames() const { return frames_; }
  std::string notices() const {
    const std::lock_guard lock(mutex_);
    return notices_;
  }

  // Whether `count` more frames come within `timeout`.
  bool sees(std::uint64_t count, std::chrono::milliseconds timeout) const {
    const std::uint64_t wanted = frames_ + count;
    for (const auto end = std::chrono::steady_clock::now() + timeout; frames_ < wanted;) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

  // Whether no frame comes for `time` within the next ten seconds.
  bool sees_nothing_for(std::chrono::milliseconds time) const {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    auto since = std::chrono::steady_clock::now();
    for (std::uint64_t last = frames_; std::chrono::steady_clock::now() < give_up;) {
      if (frames_ != last) {
        last = frames_;
        since = std::chrono::steady_clock::now();
      }
      if (std::chrono::steady_clock::now() - since > time) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  // The longest pause between two frames so far.
  std::chrono::milliseconds longest_pause() const { return std::chrono::milliseconds(longest_pause_ms_); }
  void forget_pauses() { longest_pause_ms_ = 0; }

 private:
  void watch(std::stop_token stop) {
    auto last = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      auto client = wire::FrameClient::connect(address_, std::chrono::milliseconds(2000), stop);
      if (!client) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        continue;
      }
      client->on_camera_status([this](const std::string& notice) {
        const std::lock_guard lock(mutex_);
        notices_ += "[" + notice + "]";
      });
      while (client->receive(stop)) {
        const auto now = std::chrono::steady_clock::now();
        if (frames_ > 0)
          longest_pause_ms_ = std::max<std::int64_t>(
              longest_pause_ms_, std::chrono::duration_cast<std::chrono::milliseconds>(now - last).count());
        last = now;
        ++frames_;
      }
    }
  }

  const std::string address_;
  std::atomic<std::uint64_t> frames_ = 0;
  std::atomic<std::int64_t> longest_pause_ms_ = 0;
  mutable std::mutex mutex_;
  std::string notices_;
  std::jthread thread_;
};

}  // namespace copresence::testing
