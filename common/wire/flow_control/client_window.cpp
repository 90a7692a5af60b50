#include "common/wire/flow_control/client_window.h"

#include <algorithm>
#include <cassert>

namespace copresence::wire {
namespace {

constexpr int kMostPeriods = 8, kFewestPeriods = 2;
constexpr std::chrono::milliseconds kRound{500};
constexpr std::chrono::milliseconds kAllowanceForOthersFrames{500}, kMostForKeyframe{300};
constexpr std::size_t kWantedOnUnknownPath = 2;  // two frames show how much a path carries

}  // namespace

ClientWindow::ClientWindow(Duration frame_period)
    : frame_period_(frame_period),
      path_(kFewestPeriods * frame_period),
      allowance_(kMostPeriods * frame_period) {}

Instant ClientWindow::room_until(Duration allowance, std::size_t frames_on_unknown_path) const {
  if (in_flight_.empty()) return Instant::max();
  if (in_flight_.size() >= kFrames || bytes_ >= kBytes) return Instant::min();
  const auto rate = path_.delivery_rate();
  if (!rate) return in_flight_.size() < frames_on_unknown_path ? Instant::max() : Instant::min();
  const PathEstimate::Sent& oldest = in_flight_.front().sent;
  const Duration bound = *path_.base_delay() + allowance;
  if (path_.transmission_time(bytes_) >= bound) return Instant::min();
  return oldest.at + bound + path_.transmission_time(oldest.bytes);
}

Instant ClientWindow::wants_until() const {
  if (!in_sync_) return Instant::min();
  if (in_flight_.empty()) return Instant::max();
  return std::min(room_until(allowance_, kWantedOnUnknownPath), path_.stale_at());
}

bool ClientWindow::may_have(bool keyframe, Instant now) const {
  if (!in_sync_) return keyframe && in_flight_.empty();
  // Behind a keyframe that takes long there is room, too: without successors it would not be worth its bytes.
  const Duration ahead =
      in_flight_.empty() ? Duration::zero() : path_.transmission_time(in_flight_.front().sent.bytes);
  const Duration allowance = kAllowanceForOthersFrames + std::min<Duration>(ahead, kMostForKeyframe);
  return now < room_until(std::max(allowance_, allowance), kFramesOnUnknownPath);
}

void ClientWindow::sent(std::uint64_t sequence, std::size_t bytes, Instant now) {
  in_flight_.push_back({sequence, {now, bytes, in_flight_.empty()}});
  bytes_ += bytes;
  in_sync_ = has_begun_ = true;
}

void ClientWindow::skip(std::uint64_t frames) {
  if (frames == 0) return;
  skipped_ += frames;
  in_sync_ = false;
}

bool ClientWindow::acknowledge(std::uint64_t sequence, Instant now) {
  const auto known = std::find_if(in_flight_.begin(), in_flight_.end(),
                                  [sequence](const Frame& frame) { return frame.sequence == sequence; });
  if (known == in_flight_.end()) return false;
  const auto arrived = known + 1;
  for (auto frame = in_flight_.begin(); frame != arrived; ++frame) {
    path_.acknowledged(frame->sent, now);
    bytes_ -= frame->sent.bytes;
    ++acknowledged_;
  }
  adapt_allowance(now);
  in_flight_.erase(in_flight_.begin(), arrived);
  return true;
}

std::optional<Instant> ClientWindow::waits_since() const {
  if (in_flight_.empty()) return std::nullopt;
  return in_flight_.front().sent.at;
}

void ClientWindow::adapt_allowance(Instant now) {
  const Duration queueing = path_.queueing_delay();
  if (!round_) round_ = {now + kRound, queueing};
  round_->least_queueing = std::min(round_->least_queueing, queueing);
  if (now < round_->ends_at) return;
  allowance_ = round_->least_queueing > kFewestPeriods * frame_period_
                   ? kFewestPeriods * frame_period_
                   : std::min(allowance_ + frame_period_, kMostPeriods * frame_period_);
  round_.reset();
}

}  // namespace copresence::wire
