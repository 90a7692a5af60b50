#pragma once

// Evaluates the ends of child processes and decides whether to start another child.
// Thread: the supervisor's only thread.

#include <chrono>
#include <optional>
#include <string>

#include "capture_server/supervisor/child_process.h"

namespace copresence::server {

/// Prints a sentence on standard error.
void say(const std::string& sentence);

/// Describes the end of a child in half a sentence: "x.oni: capture crashed (...) after 12 frames".
std::string what_happened(const SupervisorPolicy& policy, const ChildEnd& end);

/// The crashes and hangs of several children in a row.
class CrashHistory {
 public:
  explicit CrashHistory(const SupervisorPolicy& policy) : policy_(policy) {}

  /// The reason why no other child is started, as the end of a sentence. Returns nothing if another
  /// is started.
  std::optional<std::string> verdict(const ChildEnd& end, std::chrono::nanoseconds lived);

  /// The pause before the next child.
  std::chrono::milliseconds pause() const;

 private:
  bool is_same(const ChildEnd& a, const ChildEnd& b) const;

  const SupervisorPolicy& policy_;
  std::optional<ChildEnd> before_;
  int in_a_row_ = 0;
};

}  // namespace copresence::server
