#pragma once

// Limits the log lines about one camera. All lines that a server causes are logged through this
// class. Otherwise a hostile or broken server could fill the disk. Thread: one thread at a time.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

/// For each topic, kAtOnce lines are written at once, and then one line per kBetween. A line that
/// repeats the last line always waits for kBetween. Other lines are held back. Later, the latest
/// held-back line is written with the number of the others, for example "127.0.0.1:7001: unplugged
/// (1204 more like this)". Lines are cut to kMostBytes. Unprintable characters are replaced.
class LimitedLog {
 public:
  enum class Topic { kConnection, kSetup, kNotice, kAvailability, kTimes };
  enum class Severity { kInfo, kWarning };
  using Sink = std::function<void(Severity, const std::string&)>;

  static constexpr std::size_t kMostBytes = 400;
  static constexpr double kAtOnce = 4;
  static constexpr std::chrono::seconds kBetween{10};

  explicit LimitedLog(Sink sink) : sink_(std::move(sink)) {}

  /// Logs a line or holds it back. `now` must never decrease.
  void say(Topic topic, Severity severity, std::string_view text, Instant now);

  /// Writes lines that were held back and are due. Call it about once a second.
  void catch_up(Instant now);

  void finish();

 private:
  struct Held {
    std::uint64_t lines = 0;
    Severity severity{};
    std::string latest, last_said;
    double allowed = kAtOnce;  // Number of lines that could be written at `counted_at`.
    Instant counted_at{};
    Instant said_at{};
  };
  static void refill(Held& held, Instant now);
  void release_if_due(Held& held, Instant now);
  void release(Held& held);

  Sink sink_;
  std::array<Held, 5> topics_;  // Indexed by Topic.
};

}  // namespace copresence::wire
