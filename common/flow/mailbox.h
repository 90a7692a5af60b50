#pragma once

// A slot for one value between threads, in which a newer value replaces an older one. A mailbox is
// used where a lost frame is better than a late one: between sensor and encoder, and between
// decoder and view. Thread: any number of threads may call any member at any time.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace copresence::flow {

template <class T>
class Mailbox {
 public:
  /// Stores a value. An older value that was not taken is overwritten and counted.
  void put(T value) {
    {
      std::lock_guard lock(mutex_);
      if (slot_) ++overwritten_;
      slot_ = std::move(value);
    }
    filled_.notify_one();
  }

  /// Waits for a value and removes it. Returns nothing on a stop request, or once closed and empty.
  std::optional<T> take(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, stop, [this] { return slot_.has_value() || closed_; });
    return empty_the_slot();
  }

  /// Removes and returns the current value, if any. Does not wait.
  std::optional<T> try_take() {
    std::lock_guard lock(mutex_);
    return empty_the_slot();
  }

  /// Waits until the slot is empty. A producer that calls this before put() overwrites nothing.
  void wait_until_taken(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    emptied_.wait(lock, stop, [this] { return !slot_.has_value() || closed_; });
  }

  /// Call this after the last put(). A waiting take() returns.
  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
    emptied_.notify_all();
  }

  /// Number of values that were replaced before they were taken.
  std::uint64_t overwritten() const {
    std::lock_guard lock(mutex_);
    return overwritten_;
  }

 private:
  /// Requires that the caller holds mutex_.
  std::optional<T> empty_the_slot() {
    std::optional<T> value = std::exchange(slot_, std::nullopt);
    if (value) emptied_.notify_all();
    return value;
  }

  mutable std::mutex mutex_;
  std::condition_variable_any filled_;
  std::condition_variable_any emptied_;
  std::optional<T> slot_;
  std::uint64_t overwritten_ = 0;
  bool closed_ = false;
};

}  // namespace copresence::flow
