#pragma once

// A row of newest-wins mailboxes with one reader: what the decoders of several cameras hand to the one
// renderer.
//
// Thread: put() by any thread, take() and wait() by one reader.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/frame/rgbd_frame.h"

namespace copresence::flow {

template <class T>
class Mailboxes {
 public:
  explicit Mailboxes(std::size_t slots) : slots_(slots) {}

  /// Puts a value in; returns whether one that nobody took was lost. Requires slot < number of slots.
  bool put(std::size_t slot, T value) {
    bool lost = false;
    {
      std::lock_guard lock(mutex_);
      lost = slots_[slot].has_value();
      slots_[slot] = std::move(value);
      ++puts_;
    }
    filled_.notify_one();
    return lost;
  }

  /// What is in a slot now, without waiting.
  std::optional<T> take(std::size_t slot) {
    std::lock_guard lock(mutex_);
    return std::exchange(slots_[slot], std::nullopt);
  }

  /// Returns at the next put() after the last return, at `deadline`, or when asked to stop.
  void wait(std::stop_token stop, Instant deadline) {
    std::unique_lock lock(mutex_);
    filled_.wait_until(lock, stop, deadline, [this] { return puts_ != seen_; });
    seen_ = puts_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable_any filled_;
  std::vector<std::optional<T>> slots_;
  std::uint64_t puts_ = 0;
  std::uint64_t seen_ = 0;
};

}  // namespace copresence::flow
