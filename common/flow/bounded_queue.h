#pragma once

// A bounded queue: everything that gets in comes out in order. Used where a frame may be refused but none that was
// taken may be lost.
//
// Thread: any number of threads may call any member at any time.

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

  /// Whether put() would succeed now: for a single producer, whose values are dear to make.
  bool has_room() const {
    std::lock_guard lock(mutex_);
    return !closed_ && values_.size() < capacity_;
  }

  /// Waits for room, for `at_most`; false when there is none, when closed or asked to stop.
  bool wait_for_room(std::stop_token stop, std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    room_.wait_for(lock, stop, at_most, [this] { return closed_ || values_.size() < capacity_; });
    return !closed_ && values_.size() < capacity_;
  }

  /// Puts a value in; false, and the value gone, when full or closed.
  bool put(T value) {
    {
      std::lock_guard lock(mutex_);
      if (closed_ || values_.size() >= capacity_) return false;
      values_.push_back(std::move(value));
    }
    filled_.notify_one();
    return true;
  }

  /// Waits for a value; nothing when closed and empty.
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

  /// No more values get in; those inside still come out.
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
