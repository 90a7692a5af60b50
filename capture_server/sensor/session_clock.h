#pragma once

// Synchronises all replays of one recorded session on this machine. The recordings of a session's
// cameras begin at different times. Nevertheless all replays must show the same instant, or a
// moving person appears twice.
//
// The first replay decides when the session's first instant is due and writes that to a small file
// of this user. Other replays whose recordings overlap the first one in time use the same file.
// Every replay locks the file while it runs. So the session ends with its last replay, even if that
// is killed, and nothing has to be cleaned up.
//
// A rule from the wall clock and the recorded times alone would need no file, but has two
// drawbacks. With --loop, all recordings would need the same length. Without --loop, a replay would
// have to begin in the middle of a file.
//
// Thread: one thread at a time per object.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// The time span of a recording, in microseconds since 1970.
struct SessionSpan {
  std::int64_t from_us = 0, to_us = 0;

  bool overlaps(const SessionSpan& other) const { return from_us < other.to_us && other.from_us < to_us; }
};

/// Maps a session's instants to the steady clock. A replay with --loop repeats the session.
class SessionTimeline {
 public:
  /// `span` is the session's time span, and its first instant is due at `begin`.
  SessionTimeline(SessionSpan span, Instant begin) : span_(span), begin_(begin) {}

  const SessionSpan& span() const { return span_; }
  Instant begin() const { return begin_; }

  /// The first round, from 0, in which the recording `own` has instants that are due after `now`.
  std::int64_t round_at(const SessionSpan& own, Instant now) const {
    const Duration since_own_end = now - due(std::min(own.to_us, span_.to_us), 0);
    return since_own_end < Duration::zero() ? 0 : since_own_end / round_length() + 1;
  }

  /// The instant at which a recorded instant of the session is due in this round.
  Instant due(std::int64_t session_us, std::int64_t round) const {
    return begin_ + round * round_length() + std::chrono::microseconds(session_us - span_.from_us);
  }

  /// True if the session contains this instant. Instants outside the first replay's span are left
  /// out, so that a round has the same length for all replays.
  bool contains(std::int64_t session_us) const {
    return session_us >= span_.from_us && session_us < span_.to_us;
  }

 private:
  Duration round_length() const { return std::chrono::microseconds(span_.to_us - span_.from_us); }

  SessionSpan span_;
  Instant begin_;
};

/// Membership in a replayed session. The membership ends with this object.
class SessionClock {
 public:
  /// Joins the session that is being replayed on this machine, or starts one at `begin`. `folder`
  /// holds the session's file, see default_folder(). Returns nothing if another session is being
  /// replayed or the file cannot be created. The replay is then not synchronised.
  static std::optional<SessionClock> join(const std::string& folder, const SessionSpan& own, Instant begin);

  /// Returns $XDG_RUNTIME_DIR, or a folder of this user in /tmp. Empty if neither is usable.
  static std::string default_folder();

  SessionClock(SessionClock&& other) noexcept;
  SessionClock& operator=(SessionClock&& other) noexcept;
  ~SessionClock();

  const SessionTimeline& timeline() const { return timeline_; }
  /// True if another replay started the session.
  bool is_joined() const { return is_joined_; }

 private:
  SessionClock(int descriptor, SessionTimeline timeline, bool is_joined)
      : descriptor_(descriptor), timeline_(timeline), is_joined_(is_joined) {}

  int descriptor_;
  SessionTimeline timeline_;
  bool is_joined_;
};

}  // namespace copresence::sensor
