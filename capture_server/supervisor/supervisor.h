#pragma once

// A small parent process that survives crashes of OpenNI2 and camera drivers. A child process does
// all the work and reports its progress (heartbeat.h). If it crashes, hangs, is killed or is
// suspended, the parent prints a message and starts another child, or resumes it. Sockets that were
// opened before stay open, so clients find the same address.
//
// Thread: supervise() is called by the only thread of the process, before any library creates
// threads.

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <string>

#include "capture_server/supervisor/heartbeat.h"

namespace copresence::server {

/// Exit status of a child that ended because of SIGTERM.
inline constexpr int kEndedBySignal = 128 + SIGTERM;

struct SupervisorPolicy {
  std::string subject;         ///< the child's source, for messages: a file, a camera
  bool passes_hangup = false;  ///< SIGHUP is passed on to the child, which handles it, instead of ending both
  bool plays_recording =
      false;  ///< a crash or hang that recurs at the same place of a recording ends the server

  /// A working thread without a beat for this long counts as hung. The time in which the child got
  /// no CPU is added, up to six times this value. Time in which the child was suspended or traced,
  /// or the parent did not run, does not count.
  std::chrono::milliseconds silence{5000};
  std::chrono::milliseconds opening{20000};  ///< the same while a camera is opened, until its first frame

  /// A child that does not stop within this time is killed. The time in which it got no CPU is
  /// added, up to `stop_starved`.
  std::chrono::milliseconds stop_within{800}, stop_starved{8000};
  std::chrono::milliseconds second_stop_after{
      150};  ///< signals closer together count as one (timeout(1) sends two)

  std::chrono::milliseconds first_pause{
      100};  ///< pause before a new child; it doubles with each crash in a row, up to:
  std::chrono::milliseconds longest_pause{2000};
  std::chrono::milliseconds healthy_after{10000};  ///< a child that lived this long ends such a row
  int most_in_a_row = 10;                          ///< crashes in a row after which it gives up
  std::uint64_t same_place = 90;  ///< two crashes within this many frames are at the same place

  /// Time in which the threads of a process got no CPU, summed up; by default from the kernel.
  std::function<std::chrono::nanoseconds(pid_t)> starvation = {};
};

/// Runs `child_main` in a child process and waits for it.
///
/// The first SIGTERM or SIGINT becomes a SIGTERM for the child; a SIGINT after that kills it. The
/// child starts with SIGINT ignored, since a terminal sends it to both, and with SIGHUP blocked if
/// it is passed on. It is killed if its parent dies.
///
/// A child that ended by a crash, a hang or another process's signal is replaced. A suspended one
/// is resumed after `silence`. Each of these is reported by one sentence on standard error. The
/// supervisor gives up after a crash or hang at the same place of a recording for the second time,
/// a second crash during the same Heartbeat::Activity while preparing, a death while ending, or
/// `most_in_a_row` deaths without a healthy child in between.
///
/// Returns the result of `child_main`; 0 after a stop, even if the child crashed meanwhile or was
/// still opening its source; 1, after a message, if the child did not stop in time or no other
/// child is started; 128 plus SIGINT's number after a second Ctrl-C. Do not fork elsewhere in this
/// process: every ended child process is taken for this one.
int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main);

}  // namespace copresence::server
