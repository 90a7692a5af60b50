#pragma once

// Waiting functions that a stop request interrupts. Thread: any thread may call any function.

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stop_token>

#include "common/frame/rgbd_frame.h"

namespace copresence {

/// Waits until `instant` or until a stop request. Returns at once if `instant` has passed.
inline void wait_until(Instant instant, const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any never;
  never.wait_until(lock, stop, instant, [] { return false; });
}

inline void wait_for(Duration duration, const std::stop_token& stop) {
  wait_until(std::chrono::steady_clock::now() + duration, stop);
}

}  // namespace copresence
