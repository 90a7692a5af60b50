#include "common/wire/flow_control/arrival_watch.h"

#include <algorithm>
#include <utility>

namespace copresence::wire {

void ArrivalWatch::resume(Instant now) {
  if (message_began_at_ && paused_at_) *message_began_at_ += now - *paused_at_;
  paused_at_.reset();
  last_bytes_at_ = now;  // Bytes may have arrived during the pause.
}

void ArrivalWatch::pause(Instant now) {
  paused_at_ = now;
}

void ArrivalWatch::bytes_came(Instant at) {
  last_bytes_at_ = std::max(last_bytes_at_, at);
  if (message_began_at_) return;
  message_began_at_ = last_bytes_at_;
  message_bytes_ = 0;
}

ArrivalWatch::Verdict ArrivalWatch::at(Instant now) const {
  if (now - last_bytes_at_ > kSilence) return Verdict::kSilent;
  if (!message_began_at_) return Verdict::kAlive;
  const auto transmission = std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(static_cast<double>(message_bytes_) / kSlowestPath));
  const Duration limit = std::min<Duration>(kSilence + transmission, kLongestMessage);
  return now - *message_began_at_ > limit ? Verdict::kTooSlow : Verdict::kAlive;
}

}  // namespace copresence::wire
