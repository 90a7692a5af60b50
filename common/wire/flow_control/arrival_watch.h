#pragma once

// Detects a dead connection from the arrival of bytes. Arriving bytes show that the connection
// works, even if they are slow: at 100 kbit/s a keyframe takes 6 s. A message also has a time limit
// by its size, so a peer cannot send single bytes forever. A path below kSlowestPath is too slow.
// Time in which the client does not read does not count. Thread: distinct objects are independent.

#include <cstddef>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class ArrivalWatch {
 public:
  static constexpr std::chrono::seconds kSilence{5};  ///< Longest time without a byte.
  static constexpr double kSlowestPath = 4096;        ///< Bytes per second.
  static constexpr std::chrono::seconds kLongestMessage{60};

  enum class Verdict {
    kAlive,
    kSilent,  ///< No byte arrived for kSilence.
    /// A message took longer than kLongestMessage, or longer than kSilence plus its transmission
    /// time at kSlowestPath.
    kTooSlow,
  };

  /// Call this when reading begins, also after a pause.
  void resume(Instant now);
  void pause(Instant now);

  /// Bytes of a message arrived, the newest at `at`. The first bytes begin the message.
  void bytes_came(Instant at);
  /// Sets the size of the message that is arriving.
  void message_has(std::size_t bytes) { message_bytes_ = bytes; }
  void message_is_complete() { message_began_at_.reset(); }

  /// Returns the verdict at `now`. Requires that reading is not paused.
  Verdict at(Instant now) const;

 private:
  Instant last_bytes_at_{};
  std::optional<Instant> message_began_at_, paused_at_;
  std::size_t message_bytes_ = 0;
};

}  // namespace copresence::wire
