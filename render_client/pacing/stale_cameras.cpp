#include "render_client/pacing/stale_cameras.h"

#include <algorithm>
#include <chrono>

namespace copresence::pacing {
namespace {

constexpr int kFadeShare = 3;  // Fading begins after 1 / kFadeShare of the time of --stale.
constexpr int kPeriodsBeforeFading = 2, kPeriodsBeforeGone = 3;
/// Time between views while cameras fade and no frames arrive.
constexpr std::chrono::milliseconds kFadeStep{100};
/// Minimum time between two log lines about a camera that comes and goes.
constexpr std::chrono::seconds kSayEvery{10};

}  // namespace

Instant StaleCameras::fades_from(const Camera& camera) const {
  return *camera.newest + std::max(gone_after_ / kFadeShare, kPeriodsBeforeFading * camera.period);
}

Instant StaleCameras::gone_from(const Camera& camera) const {
  return *camera.newest + std::max(gone_after_, kPeriodsBeforeGone * camera.period);
}

void StaleCameras::frame_arrived(std::size_t camera, Duration period, Instant now) {
  cameras_[camera].newest = now;
  cameras_[camera].period = period;
}

float StaleCameras::opacity(std::size_t camera, Instant now) const {
  const Camera& of = cameras_[camera];
  if (!of.newest) return 1;
  const Instant from = fades_from(of), until = gone_from(of);
  if (now <= from) return 1;
  if (now >= until) return 0;
  return std::chrono::duration<float>(until - now) / std::chrono::duration<float>(until - from);
}

std::optional<Instant> StaleCameras::next_view(Instant drawn_at) const {
  std::optional<Instant> earliest;
  for (const Camera& camera : cameras_) {
    if (!camera.newest || drawn_at >= gone_from(camera)) continue;
    const Instant next = std::clamp<Instant>(drawn_at + kFadeStep, fades_from(camera), gone_from(camera));
    earliest = std::min(earliest.value_or(next), next);
  }
  return earliest;
}

std::vector<StaleCameras::Event> StaleCameras::changes(Instant now) {
  std::vector<Event> events;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (!camera.newest) continue;
    const bool is_stale = now > fades_from(camera);
    if (is_stale == camera.is_stale) continue;
    camera.is_stale = is_stale;
    if (is_stale) {
      camera.is_said = !camera.said_at || now - *camera.said_at >= kSayEvery;
      if (camera.is_said) camera.said_at = now;
    }
    events.push_back({i, is_stale ? Change::kStale : Change::kBack, camera.is_said});
  }
  return events;
}

}  // namespace copresence::pacing
