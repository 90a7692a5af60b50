#include "render_client/frame_sync.h"

#include <algorithm>

namespace copresence::client {
namespace {

// Of one camera: more can wait only while the render thread is far too slow.
constexpr std::size_t kMostWaiting = 4;
// A camera without a frame for so many periods has stopped, and nobody waits for it.
constexpr int kStoppedAfter = 3;

}  // namespace

void FrameSync::gather(flow::LatestOfEach<Received>& board, std::deque<CameraStatistics>& statistics,
                       Instant now) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    auto received = board.take(i);
    if (!received) continue;
    if (sync_) {
      add(cameras_[i], std::move(*received), statistics[i]);
    } else {
      cameras_[i].chosen = std::move(received);
    }
  }
  if (sync_) choose(statistics, now);
}

void FrameSync::add(Camera& camera, Received received, CameraStatistics& statistics) {
  const Duration period = std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(1 / std::max(received.stream->frames_per_second, 1.0)));
  period_ = std::max(period, std::chrono::duration_cast<Duration>(std::chrono::milliseconds(1)));
  camera.last_arrival = received.arrived_at;
  // A clock that is estimated anew may step back a little; the order of frames stays.
  Instant instant = received.captured_at;
  if (!camera.instants.empty()) instant = std::max(instant, camera.instants.back());
  if (camera.on_view) {
    // ... or far, with a server that starts anew.
    if (*camera.on_view - instant > kStoppedAfter * period_) camera.on_view = instant;
    instant = std::max(instant, *camera.on_view);
  }
  camera.instants.push_back(instant);
  camera.fresh.push_back(std::move(received));
  if (camera.fresh.size() > kMostWaiting) {
    camera.fresh.pop_front();
    camera.instants.pop_front();
    statistics.unshown();
  }
}

void FrameSync::choose(std::deque<CameraStatistics>& statistics, Instant now) {
  std::vector<pacing::CameraOffer> offers(cameras_.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    pacing::CameraOffer& offer = offers[i];
    if (camera.on_view) offer.captured.push_back(*camera.on_view);
    offer.captured.insert(offer.captured.end(), camera.instants.begin(), camera.instants.end());
    offer.first_is_on_view = camera.on_view.has_value();
    if (!camera.fresh.empty()) offer.fresh_since = camera.fresh.front().arrived_at;
    offer.delivers = camera.last_arrival && now - *camera.last_arrival < kStoppedAfter * period_;
  }
  const pacing::FrameChoice choice = pacing::nearest_instants(offers, period_, now);
  at_latest_ = choice.is_new ? std::nullopt : choice.at_latest;
  if (!choice.is_new) return;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (!choice.frames[i]) continue;
    std::size_t steps = *choice.frames[i] + (camera.on_view ? 0 : 1);  // through the frames not yet shown
    for (; steps > 0; --steps) {
      if (camera.chosen) statistics[i].unshown();
      camera.on_view = camera.instants.front();
      camera.chosen = std::move(camera.fresh.front());
      camera.chosen->arrived_at = now;
      camera.fresh.pop_front();
      camera.instants.pop_front();
    }
  }
}

std::optional<Received> FrameSync::take(std::size_t camera) {
  return std::exchange(cameras_[camera].chosen, std::nullopt);
}

bool FrameSync::has_waiting() const {
  return at_latest_.has_value();
}

Instant FrameSync::wake_by(Instant deadline) const {
  return at_latest_ ? std::min(deadline, *at_latest_) : deadline;
}

}  // namespace copresence::client
