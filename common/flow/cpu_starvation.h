#pragma once

// Distinguishes a broken thread from a thread that got no CPU. Both are silent. Thread: values; a
// CpuStarvation belongs to one thread at a time.

#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <map>

namespace copresence::flow {

/// Sums the time in which threads of a process were runnable but not scheduled.
class CpuStarvation {
 public:
  explicit CpuStarvation(pid_t process) : process_(process) {}

  /// Returns the sum since the first call. The sum never shrinks when threads end. The sum misses a
  /// thread's waits between the last call and the thread's end. The sum is zero if the kernel does
  /// not count waits (/proc/PID/task/TID/schedstat).
  std::chrono::nanoseconds look();

 private:
  const pid_t process_;
  bool has_looked_ = false;
  std::chrono::nanoseconds sum_{0};
  std::map<pid_t, std::chrono::nanoseconds> threads_;
};

/// A thread counts as broken after a silence of `usual` plus its time without CPU, at most `most`.
class StallTimeout {
 public:
  constexpr StallTimeout(std::chrono::nanoseconds usual, std::chrono::nanoseconds most)
      : usual_(usual), most_(most) {}

  constexpr bool is_over(std::chrono::nanoseconds silent, std::chrono::nanoseconds starved) const {
    return silent > std::min(usual_ + starved, most_);
  }

 private:
  std::chrono::nanoseconds usual_, most_;
};

/// Clock for a loop that calls look() often. If a call comes late because the process was
/// suspended, the clock advances by no more than `at_most`.
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

}  // namespace copresence::flow
