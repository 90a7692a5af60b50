#include "render_client/pacing/frame_sync.h"

#include <algorithm>

namespace copresence::pacing {
namespace {

// At most this many frames of a camera wait. More arrive only if the render thread is far too slow.
constexpr std::size_t kMostWaiting = 8;
// After this many periods without a frame, a camera counts as stopped and no camera waits for it.
constexpr int kStoppedAfter = 3;
// No camera waits for a camera with a longer period, since half of that would be a visible delay.
constexpr Duration kLongestPeriod = std::chrono::milliseconds(250);
constexpr Duration kShortestPeriod = std::chrono::milliseconds(1);
// A camera's period is the second longest of this many newest times between its frames, so that a
// single lost frame does not matter. The announced rate may be wrong.
constexpr std::size_t kGaps = 5;

Duration announced_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(1 / std::max(stream.frames_per_second, 1e-3)));
}

}  // namespace

void FrameSync::gather(flow::Mailboxes<client::CameraFrame>& mailboxes, Instant now) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    auto received = mailboxes.take(i);
    if (!received) continue;
    if (sync_) {
      add(i, std::move(*received));
    } else {
      cameras_[i].chosen = std::move(received);
    }
  }
  if (sync_) choose(now);
}

void FrameSync::add(std::size_t index, client::CameraFrame received) {
  Camera& camera = cameras_[index];
  camera.announced = announced_period(*received.stream);
  camera.last_arrival = received.arrived_at;
  Instant instant = received.captured_at;
  // A new estimate of the clock offset may set times back a little. The order of frames is kept
  // then. A restarted server may set times back far. Then the history is cleared.
  if (camera.newest && *camera.newest - instant > kStoppedAfter * period(camera)) {
    camera.newest.reset();
    camera.gaps.clear();
    if (camera.on_view) camera.on_view = instant;
  }
  if (!camera.instants.empty()) instant = std::max(instant, camera.instants.back());
  if (camera.on_view) instant = std::max(instant, *camera.on_view);
  if (camera.newest) camera.gaps.push_back(instant - *camera.newest);
  if (camera.gaps.size() > kGaps) camera.gaps.pop_front();
  camera.newest = instant;
  if (camera.fresh.empty()) camera.fresh_since = received.arrived_at;
  camera.instants.push_back(instant);
  camera.fresh.push_back(std::move(received));
  if (camera.fresh.size() > kMostWaiting) {
    camera.fresh.pop_front();
    camera.instants.pop_front();
    passed_over_(index);
  }
}

Duration FrameSync::period(const Camera& camera) {
  if (camera.gaps.size() < kGaps) return std::max(camera.announced, kShortestPeriod);
  std::vector<Duration> gaps(camera.gaps.begin(), camera.gaps.end());
  std::nth_element(gaps.begin(), gaps.end() - 2, gaps.end());
  return std::max(gaps[gaps.size() - 2], kShortestPeriod);
}

bool FrameSync::delivers(const Camera& camera, Instant now) {
  return camera.last_arrival && period(camera) <= kLongestPeriod &&
         now - *camera.last_arrival < kStoppedAfter * period(camera);
}

void FrameSync::choose(Instant now) {
  std::vector<CameraOffer> offers(cameras_.size());
  Duration longest = kShortestPeriod;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    CameraOffer& offer = offers[i];
    if (camera.on_view) offer.captured.push_back(*camera.on_view);
    offer.captured.insert(offer.captured.end(), camera.instants.begin(), camera.instants.end());
    offer.first_is_on_view = camera.on_view.has_value();
    offer.fresh_since = camera.fresh_since;
    offer.delivers = delivers(camera, now);
    if (offer.delivers) longest = std::max(longest, period(camera));
  }
  const FrameChoice choice = nearest_instants(offers, longest, now);
  at_latest_ = choice.is_new ? std::nullopt : choice.at_latest;
  if (!choice.is_new) return;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    if (!choice.frames[i]) continue;
    std::size_t steps = *choice.frames[i] + (camera.on_view ? 0 : 1);
    for (; steps > 0; --steps) {
      if (camera.chosen) passed_over_(i);
      camera.on_view = camera.instants.front();
      camera.chosen = std::move(camera.fresh.front());
      camera.chosen->arrived_at = now;
      camera.fresh.pop_front();
      camera.instants.pop_front();
      if (!camera.fresh.empty()) camera.fresh_since = camera.fresh.front().arrived_at;
    }
  }
}

std::optional<client::CameraFrame> FrameSync::take(std::size_t camera) {
  return std::exchange(cameras_[camera].chosen, std::nullopt);
}

bool FrameSync::has_waiting() const {
  return at_latest_.has_value();
}

Instant FrameSync::wake_by(Instant deadline) const {
  return at_latest_ ? std::min(deadline, *at_latest_) : deadline;
}

}  // namespace copresence::pacing
