#pragma once

// Several mailboxes with one reader that waits for all of them. The decoders of all cameras write,
// and the renderer reads. In each slot a newer value replaces an older one. Thread: any thread may
// call put(); one reader calls take() and wait().

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

  /// Stores a value. Returns true if this replaced a value. Requires slot < number of slots.
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

  /// Removes and returns the current value of a slot, if any. Does not wait.
  std::optional<T> take(std::size_t slot) {
    std::lock_guard lock(mutex_);
    return std::exchange(slots_[slot], std::nullopt);
  }

  /// Waits until a value was put since wait() last returned, but at most until `deadline` or a stop
  /// request.
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
