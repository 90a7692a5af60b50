#pragma once

// Tells a connection that brings bytes, however slowly, from one that died.
//
// Bytes are a sign of life, so a large frame on a slow path may take long: at 100 kbit/s a keyframe takes 6
// s. But bytes that come one by one must end somewhere, so a message has a time limit by its size as well. A
// path below kSlowestPath is too slow to watch anything over.
//
// Time during which nobody reads from the connection does not count.
//
// Thread: a value.

#include <cstddef>
#include <optional>

#include "common/frame/rgbd_frame.h"

namespace copresence::wire {

class ArrivalWatch {
 public:
  static constexpr std::chrono::seconds kSilence{5};  ///< without any byte
  static constexpr double kSlowestPath = 4096;        ///< bytes per second
  static constexpr std::chrono::seconds kLongestMessage{60};

  enum class Verdict {
    kAlive,
    kSilent,  ///< no byte for kSilence
    /// A message is not complete in time: kSilence plus its size at kSlowestPath, at most kLongestMessage.
    kTooSlow,
  };

  /// Reading begins, or goes on after a pause.
  void resume(Instant now);
  void pause(Instant now);

  /// Bytes of a message came, the newest of them at `at`; the first of them begin it.
  void bytes_came(Instant at);
  /// The size of the message that is coming.
  void message_has(std::size_t bytes) { message_bytes_ = bytes; }
  void message_is_complete() { message_began_at_.reset(); }

  /// Requires that reading is not paused.
  Verdict at(Instant now) const;

 private:
  Instant last_bytes_at_{};
  std::optional<Instant> message_began_at_, paused_at_;
  std::size_t message_bytes_ = 0;
};

}  // namespace copresence::wire
