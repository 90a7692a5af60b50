#include "render_client/pacing/render_pacer.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>

namespace copresence::pacing {
namespace {

/// Real cameras are slightly faster or slower than nominal. Each of their frames should get a view.
constexpr double kRateTolerance = 1.01;
/// A view may be early by at most this fraction of the view interval, after other views were late.
constexpr double kEarly = 1.0;
/// A view waits at most this long for its token. Otherwise the next view shows its frames.
constexpr Duration kMostDelay = std::chrono::milliseconds(4);
/// Another camera becomes the phase leader only if the gap after its frame is longer by this
/// fraction of a period. Each change can delay a view by half an interval.
constexpr double kHysteresis = 0.1;

Duration seconds(double value) {
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(value));
}

}  // namespace

RenderPacer::RenderPacer(int cameras, double views_per_second)
    : cameras_(static_cast<std::size_t>(cameras)), views_per_second_(views_per_second) {
  assert(cameras >= 1 && views_per_second > 0);
}

void RenderPacer::frame_arrived(int camera, Instant now) {
  assert(camera >= 0 && camera < static_cast<int>(cameras_.size()));
  Camera& from = cameras_[static_cast<std::size_t>(camera)];
  from.clock.arrived(now);
  from.fresh = true;
  from.passed = false;
}

void RenderPacer::rendered(Instant start) {
  const Duration interval = seconds(1 / (views_per_second_ * kRateTolerance));
  const Duration early = std::chrono::duration_cast<Duration>(kEarly * interval);
  next_token_ = std::max(next_token_, start - early) + interval;
  for (Camera& camera : cameras_) camera.fresh = camera.passed = false;
}

std::optional<Instant> RenderPacer::next_render_at(Instant now) {
  if (std::none_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) { return camera.fresh; })) {
    return std::nullopt;
  }
  choose_leaders(now);
  const Turn turn = next_turn(now);
  if (next_token_ <= turn.at + kMostDelay) return std::max(turn.at, next_token_);
  if (turn.leader && turn.leader->fresh) turn.leader->passed = true;
  return std::max(turn.next, next_token_);
}

void RenderPacer::choose_leaders(Instant now) {
  round_.clear();
  Duration period = Duration::max();
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (camera.clock.is_running(now)) {
      round_.push_back(static_cast<int>(i));
      period = std::min(period, camera.clock.period());
    } else {
      camera.leader = false;
    }
  }
  if (round_.empty()) return;

  const auto phase = [&](int index) {
    const auto since = cameras_[static_cast<std::size_t>(index)].clock.expected().time_since_epoch();
    return since % period;
  };
  std::sort(round_.begin(), round_.end(), [&](int a, int b) { return phase(a) < phase(b); });

  // Computes the gap after each camera. The hysteresis is added to the gap of a leader.
  const std::size_t count = round_.size();
  std::vector<std::pair<Duration, std::size_t>> gaps;
  for (std::size_t place = 0; place < count; ++place) {
    Duration gap = phase(round_[(place + 1) % count]) - phase(round_[place]);
    if (place + 1 == count) gap += period;
    if (camera_at(place).leader) gap += std::chrono::duration_cast<Duration>(kHysteresis * period);
    if (camera_at(place).clock.period() > period + period / 2)
      gap = -period;  // A much slower camera never becomes a leader.
    gaps.emplace_back(gap, place);
  }
  std::sort(gaps.begin(), gaps.end(), std::greater<>());
  const double views_per_period =
      views_per_second_ * kRateTolerance * std::chrono::duration<double>(period).count();
  const auto wanted = std::clamp<std::size_t>(static_cast<std::size_t>(views_per_period + 0.05), 1, count);
  for (std::size_t i = 0; i < count; ++i) {
    camera_at(gaps[i].second).leader = i < wanted && gaps[i].first >= Duration::zero();
  }
  std::rotate(round_.begin(), round_.begin() + static_cast<std::ptrdiff_t>(gaps[0].second + 1), round_.end());
}

RenderPacer::Turn RenderPacer::next_turn(Instant now) {
  // Each leader and the cameras since the previous leader form a group. A group with a new frame
  // waits for its members that are due, but not longer than their patience(). The group that is
  // complete first gets the view.
  Turn best{Instant::max(), now};
  for (std::size_t first = 0, last = 0; first < round_.size(); first = ++last) {
    while (!camera_at(last).leader) ++last;
    Camera& leader = camera_at(last);
    const bool leader_came = leader.fresh && !leader.passed;
    const Instant leaders_turn =
        leader.clock.expected() - (leader_came ? leader.clock.period() : Duration::zero());
    Instant until = now;
    bool any_fresh = false;
    for (std::size_t place = first; place <= last; ++place) {
      const Camera& camera = camera_at(place);
      any_fresh = any_fresh || camera.fresh;
      // A member whose next frame is expected long after its leader's is not due.
      const bool awaited = !camera.fresh || camera.passed;
      const bool due = awaited && camera.clock.expected() <= leaders_turn + leader.clock.patience();
      if (due) until = std::max(until, camera.clock.expected() + camera.clock.patience());
    }
    if (any_fresh && until < best.at)
      best = {until, leader.clock.expected() + leader.clock.patience(), &leader};
  }
  // If only cameras that have just started have a new frame, the view is due at once.
  if (best.at == Instant::max()) best.at = now;
  return best;
}

}  // namespace copresence::pacing
