#pragma once

// A small parent that outlives what OpenNI2 and drivers do to a process: one child does all the work; when a
// crash or a hang takes it, a recording ends with a sentence, a camera gets a new child. Sockets that were
// open before stay open for the children, so clients find the same address.
//
// Thread: supervise() is called by the only thread of the process, before any library has begun threads of
// its own.

#include <chrono>
#include <functional>
#include <string>

namespace copresence {

/// How a child says that it is alive: often, from the loop that captures frames.
/// Thread: any thread of the child.
class Heartbeat {
 public:
  /// `pipe` is written to, never blocking; stays its owner's.
  explicit Heartbeat(int pipe, bool replaces_another = false)
      : pipe_(pipe), replaces_another_(replaces_another) {}

  /// Cheap enough for every frame: one system call.
  void beat();

  /// Whether this child takes the place of one that crashed or hung.
  bool replaces_another() const { return replaces_another_; }

 private:
  int pipe_;
  bool replaces_another_;
};

struct SupervisorPolicy {
  std::string subject;         ///< what the child works on, for sentences: a file, a camera
  bool passes_hangup = false;  ///< SIGHUP goes on to the child, which waits for it, instead of ending both
  bool restart = false;  ///< a camera: a crashed or hanging child is replaced; a recording: it is the end
  std::chrono::milliseconds silence{5000};         ///< without a heartbeat a child hangs and is killed
  std::chrono::milliseconds first_silence{20000};  ///< before the first one: opening a camera takes its time
  std::chrono::milliseconds stop_within{800};      ///< after SIGTERM or SIGINT; then it is killed
  std::chrono::milliseconds first_pause{
      100};  ///< before a new child; doubles with every one in a row, up to:
  std::chrono::milliseconds longest_pause{2000};
  std::chrono::milliseconds healthy_after{10000};  ///< a child that lived this long ends such a row
  int most_in_a_row = 10;                          ///< then it gives up
};

/// Runs `child_main` in a child and waits for it. Forwards SIGTERM and SIGINT as SIGTERM, SIGHUP where asked to (a child begins with
/// that blocked, so that none comes too early for it), and leaves none behind: a child dies with its parent. Returns what `child_main` returned; 0 when it was asked to stop and
/// did not live to say; 1, after one sentence on standard error, when a child crashed, hung or did not stop
/// in time and there is no other. Forks are this function's alone: it takes every child's end as its child's.
int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main);

}  // namespace copresence
