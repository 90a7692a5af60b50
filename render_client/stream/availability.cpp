#include "render_client/stream/availability.h"

#include <algorithm>
#include <utility>

namespace copresence::stream {
namespace {

/// Returns whether the error lasts as long as the server process runs.
bool is_refusal(ErrorCode code) {
  return code == ErrorCode::kRefused || code == ErrorCode::kUnsupported || code == ErrorCode::kInvalid;
}

/// Returns whether the peer answered, but not like a capture_server. After other errors, such as a
/// refused or closed connection, the camera is awaited.
bool is_trouble(ErrorCode code) {
  return code == ErrorCode::kCorrupt || code == ErrorCode::kUnavailable;
}

}  // namespace

void AvailabilityTracker::connected() {
  first_decoded_.reset();
}

void AvailabilityTracker::decoded(Instant now) {
  if (!first_decoded_) first_decoded_ = now;
  last_decoded_ = now;
  trouble_since_.reset();
  availability_ = Availability::kShown;
}

void AvailabilityTracker::undecodable(const std::string& why, Instant now) {
  in_trouble(why, now);
}

std::optional<Duration> AvailabilityTracker::failed(const Error& why, Instant now) {
  if (first_decoded_ && *last_decoded_ - *first_decoded_ >= kSteady) next_pause_ = kFirstPause;
  first_decoded_.reset();
  if (is_refusal(why.code)) {
    trouble_since_.reset();
    availability_ = Availability::kRefused;
    reason_ = why.what;
    if (why.code == ErrorCode::kRefused) return std::nullopt;
  } else if (is_trouble(why.code)) {
    in_trouble(why.what, now);
  } else {
    trouble_since_.reset();
    availability_ = Availability::kAwaited;
  }
  return std::exchange(next_pause_, std::min<Duration>(2 * next_pause_, kLongestPause));
}

void AvailabilityTracker::in_trouble(const std::string& why, Instant now) {
  if (!trouble_since_) trouble_since_ = now;
  if (now - *trouble_since_ >= kPatience) {
    availability_ = Availability::kLeftOut;
  } else if (availability_ != Availability::kLeftOut) {
    availability_ = Availability::kAwaited;
  }
  reason_ = why;
}

}  // namespace copresence::stream
