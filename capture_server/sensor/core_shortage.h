#pragma once

// Whether silence means that something is broken or that this machine has no core to spare.
//
// Thread: pure but for what the kernel counts.

#include <algorithm>
#include <chrono>

namespace copresence::sensor {

/// How long the threads that this process has now were ready to run and got no core, all added up; zero where the kernel
/// does not tell (/proc/self/task/N/schedstat).
std::chrono::nanoseconds waited_for_a_core();

/// How long something may be silent before it counts as broken: `usual`, and longer by the time that it got no core in, up
/// to `most`.
class Patience {
 public:
  constexpr Patience(std::chrono::nanoseconds usual, std::chrono::nanoseconds most)
      : usual_(usual), most_(most) {}

  constexpr bool is_over(std::chrono::nanoseconds silent, std::chrono::nanoseconds without_a_core) const {
    return silent > std::min(usual_ + without_a_core, most_);
  }

 private:
  std::chrono::nanoseconds usual_, most_;
};

}  // namespace copresence::sensor
