#pragma once

// A small parent process that outlives what OpenNI2 and camera drivers do to a process. One child does all
// the work and reports how it gets on (heartbeat.h). When it crashes, hangs, is killed or is suspended, the
// parent says what happened and starts another child, or resumes it. Sockets that were open before stay open
// for the children, so clients find the same address.
//
// Thread: supervise() is called by the only thread of the process, before any library has started threads of
// its own.

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <string>

#include "capture_server/heartbeat.h"

namespace copresence {

/// What a child returns that ended because SIGTERM asked it to.
inline constexpr int kEndedBySignal = 128 + SIGTERM;

struct SupervisorPolicy {
  std::string subject;         ///< what the child works on, for sentences: a file, a camera
  bool passes_hangup = false;  ///< SIGHUP goes on to the child, which waits for it, instead of ending both
  bool plays_recording =
      false;  ///< a crash or hang that recurs at the same place of a recording ends the server

  /// A working thread that gives no beat for this long hangs. The time in which the child got no core is
  /// added, up to six times this; time in which the child was suspended or traced, or the parent did not run,
  /// does not count.
  std::chrono::milliseconds silence{5000};
  std::chrono::milliseconds opening{
      25000};  ///< the same for opening a camera (20 s) and its first frame (5 s)

  /// A child that was asked to stop is killed after this, plus the time in which it got no core, at most
  /// `stop_starved`.
  std::chrono::milliseconds stop_within{800}, stop_starved{8000};
  std::chrono::milliseconds second_stop_after{
      150};  ///< signals closer together are one request (timeout(1) sends two)

  std::chrono::milliseconds first_pause{100};  ///< before a new child; doubles with each one in a row, up to:
  std::chrono::milliseconds longest_pause{2000};
  std::chrono::milliseconds healthy_after{10000};  ///< a child that lived this long ends such a row
  int most_in_a_row = 10;                          ///< then it gives up
  std::uint64_t same_place = 90;                   ///< frames that two crashes at one place may be apart

  /// How long the threads of a process got no core so far, summed up; by default the kernel's account.
  std::function<std::chrono::nanoseconds(pid_t)> starvation = {};
};

/// Runs `child_main` in a child process and waits for it.
///
/// The first SIGTERM or SIGINT becomes a SIGTERM for the child; a SIGINT after that kills it. The child
/// begins with SIGINT ignored, which a terminal sends to both, and with SIGHUP blocked where that is passed
/// on. It dies with its parent.
///
/// A child that a crash, a hang or somebody else's signal ended is replaced; one that was suspended is
/// resumed after `silence`. Each of these is one sentence on standard error. The end of the server is a crash
/// or hang that recurs at the same place of a recording, a crash that recurs during the same
/// Heartbeat::Activity while preparing, a death while ending, and `most_in_a_row` deaths without a healthy
/// child between.
///
/// Returns what `child_main` returned; 0 after a stop, also where the child crashed on its way or was still
/// opening its source; 1, after a sentence, where the child did not stop in time or there is no other child;
/// 128 plus SIGINT's number after a second Ctrl-C. This function takes every child process's end as its
/// child's.
int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main);

}  // namespace copresence
