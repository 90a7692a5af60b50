#pragma once

// Computes when the frames of a replay are due. They follow the timestamps (playback_schedule.h) or
// the other replays of their session (session_clock.h).
// Thread: one thread at a time.

#include <cstdint>
#include <optional>

#include "capture_server/sensor/frame_source.h"
#include "capture_server/sensor/playback_schedule.h"
#include "capture_server/sensor/recording_description.h"
#include "capture_server/sensor/session_clock.h"

namespace copresence::sensor {

class ReplayClock {
 public:
  ReplayClock(const RecordingDescription& recording, const SourceSettings& settings);

  /// Returns the instant at which a frame is due. `timestamp_us` continues to grow over the passes
  /// of a loop. The first call joins or starts the session. Returns nothing if the session does not
  /// contain this frame, or has shown it already.
  std::optional<Instant> due(std::int64_t timestamp_us);

  /// True if the replay belongs to a session. Valid after due().
  bool is_in_session() const { return session_.has_value(); }

 private:
  void join_session(Instant now);

  const std::optional<std::int64_t> began_unix_us_;  // Without a value, the replay joins no session.
  const std::int64_t duration_us_, first_us_;
  const bool loops_;
  PlaybackSchedule schedule_;
  bool session_is_looked_for_ = false;
  std::optional<SessionClock> session_;
  std::int64_t first_round_ = 0;  // The session's round that contains the replay's first pass.
};

}  // namespace copresence::sensor
