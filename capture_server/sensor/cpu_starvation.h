#pragma once

// Tells silence because something is broken from silence because this machine has no core to spare.
//
// Thread: free functions and values; a CpuStarvation belongs to one thread at a time.

#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <map>

namespace copresence::sensor {

/// How long the threads that this process has now were ready to run but had no core, summed over the threads.
/// Zero where the kernel does not count it (/proc/self/task/N/schedstat).
std::chrono::nanoseconds waited_for_a_core();

/// The same for any process, and so that the sum never shrinks when threads end.
class CpuStarvation {
 public:
  explicit CpuStarvation(pid_t process) : process_(process) {}

  /// The sum so far, counted from the first look. What a thread waited after the last look before its end is
  /// not in it.
  std::chrono::nanoseconds look();

 private:
  const pid_t process_;
  bool has_looked_ = false;
  std::chrono::nanoseconds sum_{0};
  std::map<pid_t, std::chrono::nanoseconds> threads_;
};

/// How long something may be silent before it counts as broken: `usual`, plus the time in which it got no
/// core, but at most `most`.
class StallTimeout {
 public:
  constexpr StallTimeout(std::chrono::nanoseconds usual, std::chrono::nanoseconds most)
      : usual_(usual), most_(most) {}

  constexpr bool is_over(std::chrono::nanoseconds silent, std::chrono::nanoseconds without_a_core) const {
    return silent > std::min(usual_ + without_a_core, most_);
  }

 private:
  std::chrono::nanoseconds usual_, most_;
};

/// The time as a loop sees it pass that looks often. A look that comes later than it should, since the process was
/// suspended, counts as `at_most`.
class WatchedTime {
 public:
  using Clock = std::chrono::steady_clock;

  Clock::time_point look(std::chrono::nanoseconds at_most, Clock::time_point now = Clock::now()) {
    watched_ += std::min<std::chrono::nanoseconds>(now - last_, at_most);
    last_ = now;
    return watched_;
  }

 private:
  Clock::time_point last_ = Clock::now(), watched_ = last_;
};

}  // namespace copresence::sensor
