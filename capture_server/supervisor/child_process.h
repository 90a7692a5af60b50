#pragma once

// A child process of the supervisor: its start, the monitoring of its threads, and its end.
// Thread: the supervisor's only thread.

#include <sys/types.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "capture_server/supervisor/heartbeat.h"
#include "capture_server/supervisor/supervisor.h"
#include "common/flow/cpu_starvation.h"

namespace copresence::server {

/// Blocks the signals that the parent process waits for.
class BlockedSignals {
 public:
  explicit BlockedSignals(bool hangup_too);
  ~BlockedSignals();
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

  /// Ignores SIGINT and then unblocks it, because the parent handles a pending Ctrl-C.
  void restore_in_child() const;

  struct Arrived {
    bool stop = false;       ///< SIGTERM or SIGINT arrived.
    bool interrupt = false;  ///< SIGINT arrived.
    bool hangup = false;
  };

  /// Returns the signals that arrived within `time`. The wait also ends when a child ends.
  Arrived wait(std::chrono::milliseconds time) const;

 private:
  sigset_t before_, for_children_;
  int descriptor_ = -1;
};

/// A ChildReport in shared memory of parent and children. Each child starts with a new report.
class SharedReport {
 public:
  SharedReport();
  ~SharedReport();
  SharedReport(const SharedReport&) = delete;
  SharedReport& operator=(const SharedReport&) = delete;

  bool has_memory() const;
  /// Clears the report for the next child. Requires has_memory().
  ChildReport& begin_anew();

 private:
  void* memory_;
};

/// How a child process ended.
struct ChildEnd {
  enum class Kind {
    kNotStarted,
    kExited,
    kStopped,        ///< The child ended after a stop request, in any way.
    kWouldNotStop,   ///< The child was killed because it did not stop in time.
    kStoppedAtOnce,  ///< The child was killed on a second stop request.
    kCrashed,        ///< The child crashed by its own fault.
    kKilled,         ///< A signal from another process killed the child.
    kHung,
  };
  Kind kind = Kind::kExited;
  int code = 0;        ///< Exit status, or the signal's number.
  bool crash = false;  ///< True if the child crashed after a stop request.
  Stage stage = Stage::kPreparing;
  std::string activity{}, remedy{};
  std::uint64_t frames = 0;
  std::string thread{};                ///< The thread that crashed or hung. Empty if the thread is unknown.
  pid_t sender = 0;                    ///< Process that sent the killing signal, or 0.
  std::chrono::nanoseconds silent{0};  ///< How long the hung thread was silent.
};

/// A time limit that grows by the time in which the child got no CPU.
class Countdown {
 public:
  void begin_again(std::optional<std::chrono::nanoseconds> starved_before = std::nullopt) {
    passed_ = std::chrono::nanoseconds(0);
    starved_before_ = starved_before;
  }
  std::chrono::nanoseconds passed() const { return passed_; }

  /// Adds `step` and returns true if the limit has passed. The limit is `usual` plus the time in
  /// which the child got no CPU, at most `most`. `starved` returns that time.
  bool is_over(std::chrono::nanoseconds step, std::chrono::nanoseconds usual, std::chrono::nanoseconds most,
               const std::function<std::chrono::nanoseconds()>& starved);

 private:
  std::chrono::nanoseconds passed_{0};
  std::optional<std::chrono::nanoseconds> starved_before_;
};

class ChildProcess {
 public:
  /// Forks and runs `child_main` in the child. All arguments outlive this object.
  ChildProcess(const SupervisorPolicy& policy, const BlockedSignals& signals, ChildReport& report,
               const Predecessor& predecessor, const std::function<int(Heartbeat&)>& child_main);

  /// Passes signals on and monitors the child until it has ended.
  ChildEnd wait();

 private:
  std::chrono::milliseconds between_looks() const;
  void ask_to_stop();
  std::optional<ChildEnd> reap();
  ChildEnd ended(int status);
  ChildEnd describe(ChildEnd::Kind kind, int code) const;
  bool opens_or_closes() const;
  void resume_after(std::chrono::nanoseconds step);
  void forget_silence();
  std::optional<ChildEnd> look_at_threads(std::chrono::nanoseconds step);
  void kill_at_once() const;

  struct Watched {
    std::uint64_t beats = 0;
    Countdown silence;
  };

  const SupervisorPolicy& policy_;
  const BlockedSignals& signals_;
  ChildReport& report_;
  pid_t id_ = -1;
  std::function<std::chrono::nanoseconds()> starved_;
  std::array<Watched, ChildReport::kMostThreads> watched_;
  std::optional<std::chrono::steady_clock::time_point> stop_asked_at_;
  Countdown stopping_;
  bool suspended_ = false;
  std::chrono::nanoseconds suspension_{0};
};

}  // namespace copresence::server
