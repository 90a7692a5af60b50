#include "common/wire/limited_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/text/excerpt.h"

namespace copresence::wire {
namespace {

std::string bounded(std::string_view text) {
  std::string line = text::sanitise(text, LimitedLog::kMostBytes);
  // Replacing characters does not change the length, so a shorter line was cut.
  if (line.size() < text.size()) line += "...";
  return line;
}

}  // namespace

void LimitedLog::say(Topic topic, Severity severity, std::string_view text, Instant now) {
  Held& held = topics_[static_cast<std::size_t>(topic)];
  held.severity = severity;
  held.latest = text.substr(0, kMostBytes + 1);
  ++held.lines;
  release_if_due(held, now);
}

void LimitedLog::catch_up(Instant now) {
  for (Held& held : topics_) {
    if (held.lines > 0) release_if_due(held, now);
  }
}

void LimitedLog::finish() {
  for (Held& held : topics_) {
    if (held.lines > 0) release(held);
  }
}

void LimitedLog::refill(Held& held, Instant now) {
  if (held.counted_at != Instant{}) {
    const double periods = std::chrono::duration<double>(now - held.counted_at) / kBetween;
    held.allowed = std::min(held.allowed + periods, kAtOnce);
  }
  held.counted_at = now;
}

void LimitedLog::release_if_due(Held& held, Instant now) {
  refill(held, now);
  const bool is_repeated = held.latest == held.last_said && now - held.said_at < kBetween;
  if (held.allowed < 1 || is_repeated) return;
  held.allowed -= 1;
  held.said_at = now;
  release(held);
}

void LimitedLog::release(Held& held) {
  const std::string more = held.lines > 1 ? fmt::format(" ({} more like this)", held.lines - 1) : "";
  sink_(held.severity, bounded(held.latest) + more);
  held.lines = 0;
  held.last_said = held.latest;
}

}  // namespace copresence::wire
