#pragma once

// Which instant of a recorded session is due when, for all replays of that session on this machine. Cameras of one session
// began to be recorded at different times, and their replays are started at different times; all the same they must show
// the same instant, or a person who moves is seen twice.
//
// The first replay decides when the session's first instant is due and shares it in a small file of this user. Replays
// whose recordings overlap it in time take it over. The file is locked while anybody replays: it ends with the last of
// them, also where they are killed, and nobody has to tidy up.
//
// A rule without shared state, from the wall clock and the recorded times alone, would need the same length of all
// recordings for --loop, and without --loop it would have to begin in the middle of a file.
//
// Thread: SessionTimeline is a value; a SessionClock belongs to one thread.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "common/frame/rgbd_frame.h"

namespace copresence::sensor {

/// What a recording covers, microseconds since 1970.
struct SessionSpan {
  std::int64_t from_us = 0, to_us = 0;

  bool overlaps(const SessionSpan& other) const { return from_us < other.to_us && other.from_us < to_us; }
};

/// A session's instants on the steady clock, of a replay that may go round.
class SessionTimeline {
 public:
  /// The session `span`, whose first instant was or is due at `begin`, goes round where it is looped.
  SessionTimeline(SessionSpan span, Instant begin) : span_(span), begin_(begin) {}

  const SessionSpan& span() const { return span_; }
  Instant begin() const { return begin_; }

  /// The round in which a recording `own` that may be joined at `now` still has something to show, from 0.
  std::int64_t round_at(const SessionSpan& own, Instant now) const {
    const Duration since_own_end = now - due(std::min(own.to_us, span_.to_us), 0);
    return since_own_end < Duration::zero() ? 0 : since_own_end / round_length() + 1;
  }

  /// When an instant of the session is due in a round.
  Instant due(std::int64_t session_us, std::int64_t round) const {
    return begin_ + round * round_length() + std::chrono::microseconds(session_us - span_.from_us);
  }

  /// Whether the session shows this instant. What a recording holds beyond the first replay's is left out: a round has
  /// one length for all.
  bool contains(std::int64_t session_us) const {
    return session_us >= span_.from_us && session_us < span_.to_us;
  }

 private:
  Duration round_length() const { return std::chrono::microseconds(span_.to_us - span_.from_us); }

  SessionSpan span_;
  Instant begin_;
};

/// A place among the replays of a session, held for this object's lifetime.
class SessionClock {
 public:
  /// Joins the session that is being replayed on this machine, or begins one at `begin`. `folder` is where its file lies:
  /// default_folder(), which is this user's own.
  /// Nothing where another session is being replayed, or the file cannot be made: such a replay keeps its own time.
  static std::optional<SessionClock> join(const std::string& folder, const SessionSpan& own, Instant begin);

  /// $XDG_RUNTIME_DIR, or a folder of this user's own in /tmp. Empty where neither can be had.
  static std::string default_folder();

  SessionClock(SessionClock&& other) noexcept;
  SessionClock& operator=(SessionClock&& other) noexcept;
  ~SessionClock();

  const SessionTimeline& timeline() const { return timeline_; }
  /// Whether somebody else began it.
  bool is_joined() const { return is_joined_; }

 private:
  SessionClock(int descriptor, SessionTimeline timeline, bool is_joined)
      : descriptor_(descriptor), timeline_(timeline), is_joined_(is_joined) {}

  int descriptor_;
  SessionTimeline timeline_;
  bool is_joined_;
};

}  // namespace copresence::sensor
