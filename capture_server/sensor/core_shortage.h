#pragma once

// Whether silence means that something is broken or that this machine has no core to spare.
//
// Thread: pure but for what the kernel counts.

#include <chrono>

namespace copresence::sensor {

/// How long the threads that this process has now were ready to run and got no core, all added up; zero where the kernel
/// does not tell (/proc/self/task/N/schedstat).
std::chrono::nanoseconds waited_for_a_core();

}  // namespace copresence::sensor
