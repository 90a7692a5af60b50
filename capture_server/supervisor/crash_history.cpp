#include "capture_server/supervisor/crash_history.h"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>

#include <algorithm>
#include <cstdio>

namespace copresence::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

double seconds(nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

std::string doing(const ChildEnd& end) {
  if (!end.activity.empty()) return " while " + end.activity;
  switch (end.stage) {
    case Stage::kOpening:
      return " while opening it";
    case Stage::kRunning:
      return fmt::format(" after {} frames", end.frames);
    case Stage::kEnding:
      return " while it ended";
    default:
      return " while it began";
  }
}

// True if the recording may have caused the crash. A crash of a thread other than the capture
// thread, such as the encoder's, has another cause.
bool is_of_capture(const ChildEnd& end) {
  return end.thread.empty() || end.thread == "capture";
}

}  // namespace

void say(const std::string& sentence) {
  fmt::print(stderr, "{}\n", sentence);
  std::fflush(stderr);
}

std::string what_happened(const SupervisorPolicy& policy, const ChildEnd& end) {
  const auto in_thread = [&] {
    return end.thread.empty() ? std::string() : fmt::format(", in its thread \"{}\"", end.thread);
  };
  switch (end.kind) {
    case ChildEnd::Kind::kHung:
      return fmt::format("{}: capture hung{}, no sign of life from its thread \"{}\" for {:.1f} s",
                         policy.subject, doing(end), end.thread, seconds(end.silent));
    case ChildEnd::Kind::kWouldNotStop:
      return fmt::format("{}: capture did not stop within {:.1f} s{} and was killed", policy.subject,
                         seconds(policy.stop_within), end.activity.empty() ? "" : doing(end));
    case ChildEnd::Kind::kKilled:
      return fmt::format("{}: capture was killed by {} ({}{})", policy.subject,
                         end.sender > 0 ? fmt::format("process {}", end.sender) : "another process",
                         ::strsignal(end.code),
                         end.code == SIGKILL ? "; the system does that, too, when memory runs out" : "");
    default:
      return fmt::format("{}: capture crashed ({}){}{}", policy.subject, ::strsignal(end.code), doing(end),
                         in_thread());
  }
}

std::optional<std::string> CrashHistory::verdict(const ChildEnd& end, nanoseconds lived) {
  if (lived >= policy_.healthy_after) in_a_row_ = 0;
  ++in_a_row_;
  const bool recurs = before_ && is_same(*before_, end);
  if (end.kind != ChildEnd::Kind::kKilled) before_ = end;
  if (recurs && end.stage == Stage::kPreparing && !end.remedy.empty())
    return ", twice in a row; " + end.remedy;
  const bool of_recording =
      policy_.plays_recording && (end.stage == Stage::kOpening || end.stage == Stage::kRunning);
  if (recurs && of_recording && end.kind == ChildEnd::Kind::kCrashed && is_of_capture(end))
    return ", for the second time at this place: the recording is damaged where its check does not see it; "
           "record it "
           "again or take another copy";
  if (recurs && of_recording && end.kind == ChildEnd::Kind::kHung)
    return ", for the second time at this place; see what record info says of the file, and end other "
           "programs";
  if (in_a_row_ < policy_.most_in_a_row) return std::nullopt;
  if (end.kind == ChildEnd::Kind::kKilled)
    return fmt::format(", {} times in a row; end what kills it, or make room in memory", in_a_row_);
  return fmt::format(", {} times in a row; {}", in_a_row_,
                     policy_.plays_recording ? "please report this with the recording"
                                             : "unplug the camera and start again");
}

milliseconds CrashHistory::pause() const {
  milliseconds pause = policy_.first_pause;
  for (int i = 1; i < in_a_row_ && pause < policy_.longest_pause; ++i) pause *= 2;
  return std::min(pause, policy_.longest_pause);
}

bool CrashHistory::is_same(const ChildEnd& a, const ChildEnd& b) const {
  const std::uint64_t apart = a.frames > b.frames ? a.frames - b.frames : b.frames - a.frames;
  return a.kind == b.kind && a.stage == b.stage && a.activity == b.activity && a.thread == b.thread &&
         apart <= policy_.same_place;
}

}  // namespace copresence::server
