#pragma once

// Thread priorities for a machine with fewer cores than busy threads. Latency ends when a view is
// displayed. So stages near the display have a higher priority than stages near the sensor. Thread:
// any thread may call any function.

namespace copresence::flow {

/// Lowers the priority of the calling thread, and of the threads that it creates later, by `steps`
/// of nice (1 to 19). This cannot be undone. A lower priority costs nothing while a core is idle.
void lower_priority(int steps);

}  // namespace copresence::flow
