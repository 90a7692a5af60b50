#include "capture_server/sensor/replay_clock.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace copresence::sensor {
namespace {

// A frame that the session showed more than this time ago is skipped.
constexpr Duration kLate = std::chrono::milliseconds(200);
// A replay without --loop skips at most this much of its beginning to be in sync with its session.
constexpr Duration kLatestJoin = std::chrono::seconds(10);

}  // namespace

ReplayClock::ReplayClock(const RecordingDescription& recording, const SourceSettings& settings)
    : began_unix_us_(settings.begin ? std::nullopt : recording.began_unix_us),
      duration_us_(recording.duration_us),
      first_us_(recording.first_us),
      loops_(settings.loop),
      schedule_(std::chrono::microseconds(std::llround(recording.period_us)), settings.begin) {}

void ReplayClock::join_session(Instant now) {
  if (std::exchange(session_is_looked_for_, true) || !began_unix_us_) return;
  const SessionSpan own{*began_unix_us_, *began_unix_us_ + duration_us_};
  session_ = SessionClock::join(SessionClock::default_folder(), own, PlaybackSchedule::in_sync(now));
  if (!session_) return;
  const SessionTimeline& timeline = session_->timeline();
  first_round_ = timeline.round_at(own, now);
  const Instant own_begin = timeline.due(std::max(own.from_us, timeline.span().from_us), 0);
  if (!loops_ && (first_round_ > 0 || now - own_begin > kLatestJoin)) session_.reset();
}

std::optional<Instant> ReplayClock::due(std::int64_t timestamp_us) {
  const Instant now = std::chrono::steady_clock::now();
  join_session(now);
  if (!session_) return schedule_.due(timestamp_us, now);
  const std::int64_t since_first = timestamp_us - first_us_;
  const std::int64_t session_us = *began_unix_us_ + since_first % duration_us_;
  const SessionTimeline& timeline = session_->timeline();
  const Instant due = timeline.due(session_us, first_round_ + since_first / duration_us_);
  if (!timeline.contains(session_us) || now - due > kLate) return std::nullopt;
  return due;
}

}  // namespace copresence::sensor
