#pragma once

// A thread that calls a function periodically until it is destroyed.
// Thread: its owner creates and destroys it. The function runs on the new thread.

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace copresence::drivers {

class PeriodicThread {
 public:
  /// Calls `look` every `period`, for the first time after one period.
  PeriodicThread(std::chrono::milliseconds period, std::function<void()> look)
      : thread_([period, look = std::move(look)](const std::stop_token& stop) {
          std::mutex sleeping;
          std::condition_variable_any never;
          std::unique_lock lock(sleeping);
          while (!stop.stop_requested()) {
            never.wait_for(lock, stop, period, [] { return false; });
            if (!stop.stop_requested()) look();
          }
        }) {}

 private:
  std::jthread thread_;  // The destructor stops the thread and joins it.
};

}  // namespace copresence::drivers
