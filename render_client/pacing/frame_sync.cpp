#include "render_client/pacing/frame_sync.h"

#include <algorithm>

namespace copresence::client {
namespace {

// Of one camera: a fast one waits for a slow one with as many, and more come only while the render thread is
// far too slow.
constexpr std::size_t kMostWaiting = 8;
// A camera without a frame for so many of its periods has stopped, and nobody waits for it.
constexpr int kStoppedAfter = 3;
// Nobody waits for a slower camera: half of its period would be a delay that everybody sees.
constexpr Duration kLongestPeriod = std::chrono::milliseconds(250);
constexpr Duration kShortestPeriod = std::chrono::milliseconds(1);
// Of the newest gaps between a camera's frames the second longest is its period: frames may come at half of
// the announced rate, and a single lost frame changes nothing.
constexpr std::size_t kGaps = 5;

Duration announced_period(const StreamDescription& stream) {
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(1 / std::max(stream.frames_per_second, 1e-3)));
}

}  // namespace

void FrameSync::gather(flow::Mailboxes<Received>& board, std::deque<CameraStatistics>& statistics,
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
  camera.announced = announced_period(*received.stream);
  camera.last_arrival = received.arrived_at;
  Instant instant = received.captured_at;
  // A clock that is estimated anew may step back a little; the order of frames stays. It steps back far with
  // a server that starts anew.
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
    statistics.unshown();
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

void FrameSync::choose(std::deque<CameraStatistics>& statistics, Instant now) {
  std::vector<pacing::CameraOffer> offers(cameras_.size());
  Duration longest = kShortestPeriod;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    pacing::CameraOffer& offer = offers[i];
    if (camera.on_view) offer.captured.push_back(*camera.on_view);
    offer.captured.insert(offer.captured.end(), camera.instants.begin(), camera.instants.end());
    offer.first_is_on_view = camera.on_view.has_value();
    offer.fresh_since = camera.fresh_since;
    offer.delivers = delivers(camera, now);
    if (offer.delivers) longest = std::max(longest, period(camera));
  }
  const pacing::FrameChoice choice = pacing::nearest_instants(offers, longest, now);
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
      if (!camera.fresh.empty()) camera.fresh_since = camera.fresh.front().arrived_at;
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
