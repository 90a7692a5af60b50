#include "render_client/stream/frame_times.h"

namespace copresence::stream {
namespace {

// Times may be in the wrong order by this much, since the kernel rounds arrival times.
constexpr std::chrono::milliseconds kTolerance{5};
// No clock reaches this time. The sum of three such times does not overflow.
constexpr Duration kLatest = Duration::max() / 8;

bool is_sane(Instant instant) {
  return instant.time_since_epoch() >= -kLatest && instant.time_since_epoch() <= kLatest;
}

}  // namespace

FrameTimes frame_times(Instant captured_at, Instant sent_at, Instant received_at,
                       const wire::ClockOffset& clock) {
  const FrameTimes unbelievable{received_at, std::nullopt};
  if (!is_sane(captured_at) || !is_sane(sent_at)) return unbelievable;
  const Duration on_the_way = received_at - clock.to_local(sent_at);
  const Duration age = received_at - clock.to_local(captured_at);
  const bool in_order =
      captured_at <= sent_at + kTolerance && on_the_way >= -(clock.uncertainty + kTolerance);
  if (!in_order || age > kOldestBelieved + clock.uncertainty) return unbelievable;
  return {clock.to_local(captured_at), on_the_way};
}

}  // namespace copresence::stream
