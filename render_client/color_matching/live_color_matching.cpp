#include "render_client/color_matching/live_color_matching.h"

#include <algorithm>

#include "common/flow/waiting.h"

namespace copresence::client {
namespace {

// Exposure changes over seconds; a round costs a few milliseconds of one core.
constexpr std::chrono::milliseconds kPeriod{500};
// A camera that has just begun to send is not left waiting for its first round.
constexpr std::chrono::milliseconds kFirstPeriod{50};

}  // namespace

LiveColorMatching::LiveColorMatching(std::size_t cameras)
    : cameras_(cameras), rounds_(cameras), steady_(cameras) {}

void LiveColorMatching::show(std::size_t camera, std::shared_ptr<const Received> received,
                             const color_matching::PosedFrame& placed) {
  std::lock_guard lock(mutex_);
  cameras_[camera] = {std::move(received), placed};
}

void LiveColorMatching::forget(std::size_t camera) {
  std::lock_guard lock(mutex_);
  cameras_[camera] = {};
}

bool LiveColorMatching::is_matched(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return steady_.is_known(camera);
}

LiveColorMatching::FirstMatch LiveColorMatching::first_match(std::span<const std::size_t> cameras) const {
  std::lock_guard lock(mutex_);
  const auto all = [&](auto&& holds) { return std::all_of(cameras.begin(), cameras.end(), holds); };
  if (all([this](std::size_t i) { return steady_.is_known(i); })) return FirstMatch::kFound;
  if (all([this](std::size_t i) { return rounds_[i] >= kRoundsToGiveUp; })) return FirstMatch::kGivenUp;
  return FirstMatch::kAwaited;
}

color_matching::ColorCorrection LiveColorMatching::map(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return steady_.map(camera);
}

void LiveColorMatching::run(std::stop_token stop) {
  Instant last = std::chrono::steady_clock::now();
  while (!stop.stop_requested()) {
    wait_for(until_next_round(), stop);
    if (stop.stop_requested()) return;
    const Instant now = std::chrono::steady_clock::now();
    compare(now - last);
    last = now;
  }
}

Duration LiveColorMatching::until_next_round() const {
  std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (cameras_[i].placed.frame && rounds_[i] == 0) return kFirstPeriod;
  }
  return kPeriod;
}

void LiveColorMatching::compare(Duration elapsed) {
  std::vector<Camera> cameras;
  {
    std::lock_guard lock(mutex_);
    cameras = cameras_;  // which keeps the frames until they are compared
  }
  std::vector<color_matching::PosedFrame> frames;
  for (const Camera& camera : cameras) frames.push_back(camera.placed);
  const auto takes_part = [](const color_matching::PosedFrame& frame) { return frame.frame != nullptr; };
  if (std::count_if(frames.begin(), frames.end(), takes_part) < 2) return;
  const auto found = color_matching::match_colors(frames);
  std::lock_guard lock(mutex_);
  steady_.follow(found, elapsed);
  for (std::size_t i = 0; i < frames.size(); ++i) rounds_[i] += takes_part(frames[i]);
}

}  // namespace copresence::client
