#pragma once

// Who gives way when frames want more cores than there are. A frame's latency ends with the view that shows it, so
// the stages nearer to the view go first: work on an older frame before work on a newer one.

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace copresence::flow {

/// The calling thread, and those it makes from now on, give way to others by so many steps of nice (1 to 19), for good.
/// Where nothing else wants the core they lose nothing.
inline void give_way(int steps) {
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + steps);
}

}  // namespace copresence::flow
