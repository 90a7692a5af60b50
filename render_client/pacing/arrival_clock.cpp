#include "render_client/pacing/arrival_clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

namespace copresence::pacing {
namespace {

using std::chrono::milliseconds;

// Gains of an alpha-beta filter. At first the filter is a mean over all arrivals. Later it forgets
// old arrivals over about twenty frames, and thus follows the drift between two cameras (0.1 %). It
// reduces a jitter of 3 ms to 1 ms.
constexpr double kSettledPhaseGain = 0.1;
constexpr double kSettledPeriodGain = 0.005;
constexpr double kJitterGain = 0.05;
constexpr int kSettledCount = 40;
// After this many consecutive lost frames, the camera is assumed to have become slower.
constexpr int kSkipsBeforeRestart = 4;
constexpr Duration kShortestPeriod = milliseconds(4);
constexpr Duration kLeastPatience = milliseconds(2), kMostPatience = milliseconds(8);
constexpr Duration kPause = milliseconds(150);

Duration scaled(Duration duration, double factor) {
  return Duration(std::llround(static_cast<double>(duration.count()) * factor));
}

}  // namespace

void ArrivalClock::restart(Instant now) {
  period_ = std::max<Duration>(now - last_, kShortestPeriod);
  phase_ = now;
  count_ = 2;
  skipped_ = 0;
  jitter_ = Duration::zero();
}

void ArrivalClock::arrived(Instant now) {
  if (count_ == 0 || now - last_ > kPause) {
    count_ = 1;
    last_ = phase_ = now;
    return;
  }
  if (count_ == 1) {
    restart(now);
    last_ = now;
    return;
  }
  const double elapsed_periods =
      static_cast<double>((now - phase_).count()) / static_cast<double>(period_.count());
  const double periods = std::max(1.0, std::round(elapsed_periods));
  const Duration error = now - (phase_ + scaled(period_, periods));
  skipped_ = periods > 1 ? skipped_ + 1 : 0;
  if (std::chrono::abs(error) > period_ / 3 || skipped_ >= kSkipsBeforeRestart) {
    restart(now);
    last_ = now;
    return;
  }
  const double k = count_;
  const double phase_gain = std::max(kSettledPhaseGain, 2 * (2 * k + 1) / ((k + 1) * (k + 2)));
  const double period_gain = std::max(kSettledPeriodGain, 6 / ((k + 1) * (k + 2)));
  phase_ += scaled(period_, periods) + scaled(error, phase_gain);
  period_ = std::max(period_ + scaled(error, period_gain / periods), kShortestPeriod);
  jitter_ += scaled(std::chrono::abs(error) - jitter_, std::max(kJitterGain, 1 / k));
  count_ = std::min(count_ + 1, kSettledCount);
  last_ = now;
}

bool ArrivalClock::is_running(Instant now) const {
  return count_ >= 2 && now - last_ <= std::max(kPause, 4 * period_);
}

Duration ArrivalClock::patience() const {
  // The ratio of the standard deviation to the mean absolute error, for a normal distribution.
  constexpr double kDeviationsPerMean = 1.25;
  return std::clamp(scaled(jitter_, 3 * kDeviationsPerMean), kLeastPatience, kMostPatience);
}

}  // namespace copresence::pacing
