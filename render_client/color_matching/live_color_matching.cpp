#include "render_client/color_matching/live_color_matching.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/flow/waiting.h"

namespace copresence::color_matching {
namespace {

// Time between comparisons. Exposure changes within seconds, and a comparison takes a few ms.
constexpr std::chrono::milliseconds kPeriod{500};
// Time between comparisons while some camera has not taken part in any comparison yet.
constexpr std::chrono::milliseconds kFirstPeriod{50};

}  // namespace

PosedFrame posed_frame(const client::CameraFrame& frame) {
  const client::CameraSetup& setup = *frame.setup;
  return {&frame.frame, setup.model, setup.unit, setup.noise, frame.pose(), setup.calibration_error_m};
}

LiveColorMatching::LiveColorMatching(std::size_t cameras)
    : newest_(cameras), rounds_(cameras), steady_(cameras) {}

void LiveColorMatching::show(std::size_t camera, std::shared_ptr<const client::CameraFrame> frame) {
  std::lock_guard lock(mutex_);
  newest_[camera] = std::move(frame);
}

void LiveColorMatching::forget(std::size_t camera) {
  std::lock_guard lock(mutex_);
  newest_[camera].reset();
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

ColorCorrection LiveColorMatching::correction(std::size_t camera) const {
  std::lock_guard lock(mutex_);
  return steady_.correction(camera);
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

void LiveColorMatching::compare_if_due(Instant now) {
  if (compared_at_ && now < *compared_at_ + until_next_round()) return;
  compare(now - compared_at_.value_or(now));
  compared_at_ = now;
}

Duration LiveColorMatching::until_next_round() const {
  std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < newest_.size(); ++i) {
    if (newest_[i] && rounds_[i] == 0) return kFirstPeriod;
  }
  return kPeriod;
}

void LiveColorMatching::compare(Duration elapsed) {
  Frames newest;
  {
    std::lock_guard lock(mutex_);
    newest = newest_;
  }
  std::vector<PosedFrame> frames;
  for (const auto& frame : newest) frames.push_back(frame ? posed_frame(*frame) : PosedFrame{});
  const auto takes_part = [](const PosedFrame& frame) { return frame.frame != nullptr; };
  if (std::count_if(frames.begin(), frames.end(), takes_part) < 2) return;
  const auto found = match_colors(frames);
  std::lock_guard lock(mutex_);
  steady_.follow(found, elapsed);
  for (std::size_t i = 0; i < frames.size(); ++i) rounds_[i] += takes_part(frames[i]);
}

}  // namespace copresence::color_matching
