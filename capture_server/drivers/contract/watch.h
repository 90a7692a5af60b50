#pragma once

// A thread that looks at something now and then, until its owner is done with it.
//
// Thread: made and destroyed by its owner's; `look` runs on the watch's own.

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace copresence::drivers {

class Watch {
 public:
  /// Calls `look` every `period`, for the first time after one.
  Watch(std::chrono::milliseconds period, std::function<void()> look)
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
  std::jthread thread_;  // joins at the end
};

}  // namespace copresence::drivers
