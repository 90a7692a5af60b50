#include "capture_server/supervisor/supervisor.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "capture_server/supervisor/child_process.h"
#include "capture_server/supervisor/crash_history.h"

namespace copresence::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

}  // namespace

int supervise(const SupervisorPolicy& policy, const std::function<int(Heartbeat&)>& child_main) {
  const BlockedSignals signals(policy.passes_hangup);
  SharedReport report;
  CrashHistory history(policy);
  Predecessor predecessor;
  while (true) {
    const auto begin = Clock::now();
    ChildEnd end{.kind = ChildEnd::Kind::kNotStarted, .code = ENOMEM};
    if (report.has_memory())
      end = ChildProcess(policy, signals, report.begin_anew(), predecessor, child_main).wait();
    switch (end.kind) {
      case ChildEnd::Kind::kNotStarted:
        say(fmt::format("{}: no process for capturing: {}; end other programs", policy.subject,
                        std::strerror(end.code)));
        return 1;
      case ChildEnd::Kind::kExited:
        return end.code;
      case ChildEnd::Kind::kStopped:
        if (end.crash) say(what_happened(policy, end) + ", when it was asked to stop");
        return 0;
      case ChildEnd::Kind::kStoppedAtOnce:
        return 128 + end.code;
      case ChildEnd::Kind::kWouldNotStop:
        if (end.stage == Stage::kOpening || end.stage == Stage::kPreparing) return 0;  // Nothing was lost.
        say(what_happened(policy, end));
        return 1;
      default:
        break;
    }
    if (end.stage == Stage::kEnding) {  // Its work was done.
      say(what_happened(policy, end));
      return 1;
    }
    if (const auto verdict = history.verdict(end, Clock::now() - begin)) {
      say(what_happened(policy, end) + *verdict);
      return 1;
    }
    say(what_happened(policy, end) + "; starting it again");
    predecessor = {true, end.kind == ChildEnd::Kind::kCrashed ? end.activity : std::string()};
    for (const auto until = Clock::now() + history.pause(); Clock::now() < until;) {
      const auto left = std::chrono::ceil<milliseconds>(until - Clock::now());
      if (signals.wait(std::max(left, milliseconds(1))).stop)
        return 0;  // A new child reads the settings file, so SIGHUP needs no action.
    }
  }
}

}  // namespace copresence::server
