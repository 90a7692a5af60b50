#pragma once

// Lines in the log about one camera. What a server says or does causes them, so a hostile or broken one could
// fill a disk: everything that a peer causes goes through here.
//
// Thread: a value of one thread.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "common/frame/rgbd_frame.h"

namespace copresence::client {

/// Of each topic kAtOnce lines pass at once and then one in kBetween; the same line again waits that long in
/// any case. The latest line that was held back is said when its turn comes, with the number of others that
/// it stands for: "127.0.0.1:7001: unplugged (1204 more like this)". A line is cut to kMostBytes and
/// printable whatever it was made of.
class LimitedLog {
 public:
  enum class Topic { kConnection, kSetup, kNotice, kAvailability, kTimes };
  enum class Severity { kInfo, kWarning };
  using Sink = std::function<void(Severity, const std::string&)>;

  static constexpr std::size_t kMostBytes = 400;
  static constexpr double kAtOnce = 4;
  static constexpr std::chrono::seconds kBetween{10};

  explicit LimitedLog(Sink sink) : sink_(std::move(sink)) {}

  /// Time never goes back.
  void say(Topic topic, Severity severity, std::string_view text, Instant now);

  /// Says what was held back and may be said by now. Call it now and then.
  void catch_up(Instant now);

  /// Says all that is held back.
  void finish();

 private:
  struct Held {
    std::uint64_t lines = 0;
    Severity severity{};
    std::string latest, last_said;
    double allowed = kAtOnce;  // lines that may pass now
    Instant counted_at{};      // `allowed` holds for this instant
    Instant said_at{};
  };
  static void refill(Held& held, Instant now);
  void release_if_due(Held& held, Instant now);
  void release(Held& held);

  Sink sink_;
  std::array<Held, 5> topics_;  // by Topic
};

}  // namespace copresence::client
