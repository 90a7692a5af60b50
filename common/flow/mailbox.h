#pragma once

// A mailbox of one slot where the newest wins: the latency policy of this program. Used where a frame may be
// lost, between sensor and encoder and between decoder and view.
//
// Thread: any number of threads may call any member at any time.

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
  /// Puts a value in; one that nobody took is lost and counted.
  void put(T value) {
    {
      std::lock_guard lock(mutex_);
      if (slot_) ++overwritten_;
      slot_ = std::move(value);
    }
    filled_.notify_one();
  }

  /// Waits for a value; nothing when asked to stop, or when closed and empty.
  std::optional<T> take(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, stop, [this] { return slot_.has_value() || closed_; });
    return empty_the_slot();
  }

  /// What is there now, without waiting.
  std::optional<T> try_take() {
    std::lock_guard lock(mutex_);
    return empty_the_slot();
  }

  /// Waits until nothing is in the slot: for a producer that can wait, and then loses nothing.
  void wait_until_taken(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    emptied_.wait(lock, stop, [this] { return !slot_.has_value() || closed_; });
  }

  /// No more values will come; a waiting take() returns.
  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
    emptied_.notify_all();
  }

  /// Values that were replaced before anybody took them.
  std::uint64_t overwritten() const {
    std::lock_guard lock(mutex_);
    return overwritten_;
  }

 private:
  /// Call with mutex_ held.
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
