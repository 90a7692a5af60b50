#pragma once

// Thread priorities for a machine with fewer cores than busy threads. Latency ends when a view is
// displayed, so stages near the display have a higher priority than stages near the sensor.
//
// Thread: any thread may call any function.

#include <sys/types.h>

#include <set>

namespace copresence::flow {

/// Lowers the priority of the calling thread, and of the threads that it creates later, by `steps`
/// of nice (1 to 19). This cannot be undone. It costs nothing while a core is idle.
void lower_priority(int steps);

/// Lowers the priority of threads that a library creates. The thread that calls the library keeps
/// its priority.
class NewThreads {
 public:
  /// Construct it before the library creates its threads: threads that exist now keep their
  /// priority.
  NewThreads();

  /// Lowers the priority of all threads of this process that were created since the construction.
  void lower_priority(int steps) const;

 private:
  std::set<pid_t> before_;
};

}  // namespace copresence::flow
