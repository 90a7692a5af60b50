#pragma once

// Who gives way when frames want more cores than there are. A frame's latency ends with the view that shows
// it, so the stages nearer to the view go first: work on an older frame before work on a newer one.
//
// Thread: safe anywhere.

#include <sys/types.h>

#include <set>

namespace copresence::flow {

/// The calling thread, and those it makes from now on, give way to others by so many steps of nice (1 to 19),
/// for good. Where nothing else wants the core they lose nothing.
void lower_priority(int steps);

/// Lowers the priority of threads that a library makes for itself, while the thread that calls the library
/// keeps its own.
class NewThreads {
 public:
  /// Threads that exist now are not meant.
  NewThreads();

  /// Every thread of this process that was made since gives way, as above.
  void lower_priority(int steps) const;

 private:
  std::set<pid_t> before_;
};

}  // namespace copresence::flow
