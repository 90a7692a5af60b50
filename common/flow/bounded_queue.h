#pragma once

// A first-in, first-out queue of limited length between threads. A full queue rejects new values
// and never loses an accepted one. Thread: any number of threads may call any member at any time.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

namespace copresence::flow {

template <class T>
class BoundedQueue {
 public:
  /// Requires capacity > 0.
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

  /// True if put() would succeed now. If there is only one producer, it can check this before it
  /// makes an expensive value.
  bool has_room() const {
    std::lock_guard lock(mutex_);
    return !closed_ && values_.size() < capacity_;
  }

  /// Waits up to `at_most` until put() would succeed. Returns false on a timeout, on a stop
  /// request, or if the queue is closed.
  bool wait_for_room(std::stop_token stop, std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    room_.wait_for(lock, stop, at_most, [this] { return closed_ || values_.size() < capacity_; });
    return !closed_ && values_.size() < capacity_;
  }

  /// Appends a value. Returns false and discards the value if the queue is full or closed.
  bool put(T value) {
    {
      std::lock_guard lock(mutex_);
      if (closed_ || values_.size() >= capacity_) return false;
      values_.push_back(std::move(value));
    }
    filled_.notify_one();
    return true;
  }

  /// Waits for the oldest value and removes it. Returns nothing once the queue is closed and empty.
  std::optional<T> take() {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [this] { return closed_ || !values_.empty(); });
    if (values_.empty()) return std::nullopt;
    std::optional<T> value(std::move(values_.front()));
    values_.pop_front();
    lock.unlock();
    room_.notify_one();
    return value;
  }

  /// Rejects all further values. take() still returns the values in the queue.
  void close() {
    {
      std::lock_guard lock(mutex_);
      closed_ = true;
    }
    filled_.notify_all();
    room_.notify_all();
  }

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable_any room_;
  std::deque<T> values_;
  bool closed_ = false;
};

}  // namespace copresence::flow
