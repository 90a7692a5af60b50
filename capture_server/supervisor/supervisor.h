#pragma once

// A small parent process that survives crashes of OpenNI2 and of camera drivers. A child process
// does all the work and reports its progress (heartbeat.h). If the child crashes, hangs or is
// killed, the parent prints a message and starts another child. If the child is suspended, the
// parent resumes it. Sockets that the parent has opened stay open, so clients find each new child
// at the same address. Thread: the only thread of the process calls supervise(), before any library
// creates threads.

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <string>

#include "capture_server/supervisor/heartbeat.h"

namespace copresence::server {

inline constexpr int kEndedBySignal = 128 + SIGTERM;

struct SupervisorPolicy {
  std::string subject;  ///< The child's source, such as a file or a camera, for messages.
  /// Passes SIGHUP on to the child, which handles it, instead of ending both processes.
  bool passes_hangup = false;
  /// Ends the server if a crash or hang recurs at the same place of a recording.
  bool plays_recording = false;

  /// A working thread that is silent for this long counts as hung. The time in which the child got
  /// no CPU is added, up to six times this value. Time in which the child was suspended or traced,
  /// or in which the parent did not run, does not count.
  std::chrono::milliseconds silence{5000};
  std::chrono::milliseconds opening{20000};  ///< The limit of silence while a camera is opened.

  /// A child that does not stop within this time is killed. The time in which the child got no CPU
  /// is added, up to `stop_starved`.
  std::chrono::milliseconds stop_within{800}, stop_starved{8000};
  /// Stop signals that are closer together count as one, because timeout(1) sends two.
  std::chrono::milliseconds second_stop_after{150};

  /// Pause before a new child. The pause doubles with each crash in a row, up to `longest_pause`.
  std::chrono::milliseconds first_pause{100};
  std::chrono::milliseconds longest_pause{2000};
  /// If a child lives this long, its crash is the first of a new row.
  std::chrono::milliseconds healthy_after{10000};
  int most_in_a_row = 10;  ///< The supervisor gives up after this many crashes in a row.
  /// In frames. Two crashes are at the same place if at most this many frames lie between.
  std::uint64_t same_place = 90;

  /// Sum of the time in which a process's threads got no CPU. The default is the kernel's figure.
  std::function<std::chrono::nanoseconds(pid_t)> starvation = {};
};

/// Runs `child_main` in a child process and waits for it.
///
/// The first SIGTERM or SIGINT becomes a SIGTERM for the child, and a later SIGINT kills it. The
/// child starts with SIGINT ignored, since a terminal sends it to both processes, and with SIGHUP
/// blocked if it is passed on. The child is killed if its parent dies.
///
/// A child that ended by a crash, a hang or another process's signal is replaced. A suspended child
/// is resumed after `silence`. A sentence on standard error reports each of these events. The
/// supervisor gives up after a second crash or hang at the same place of a recording, or a second
/// crash during the same Heartbeat::Activity in the stage kPreparing. It also gives up after a
/// death in the stage kEnding, or after `most_in_a_row` deaths in a row.
///
/// Returns the result of `child_main`. After a stop it returns 0, even if the child crashed or was
/// still opening its source. The result is 1, after a message, if the child did not stop in time or
/// no other child is started. The result is 128 plus SIGINT's number after a second Ctrl-C. Do not
/// fork elsewhere in this process, since every ended child process is taken for this one.
int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main);

}  // namespace copresence::server
