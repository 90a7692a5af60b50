#include "common/wire/flow_control/client_window.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace copresence::wire {
namespace {

constexpr int kMostPeriods = 8, kFewestPeriods = 2;
constexpr std::chrono::milliseconds kRound{500};
constexpr std::chrono::seconds kLatenessSpan{5};
constexpr std::chrono::milliseconds kAllowanceForOthersFrames{500}, kMostForKeyframe{300};
constexpr std::size_t kWantedOnUnknownPath = 2;  // Two frames are needed to measure the delivery rate.
constexpr int kOverdueWanted = 3, kOverdueAccepted = 5;

}  // namespace

ClientWindow::ClientWindow(Duration frame_period)
    : frame_period_(frame_period),
      path_(kFewestPeriods * frame_period),
      allowance_(kMostPeriods * frame_period) {}

Instant ClientWindow::room_until(const Limits& limits) const {
  if (in_flight_.empty()) return Instant::max();
  if (in_flight_.size() >= kFrames || bytes_ >= kBytes) return Instant::min();
  if (!path_.delivery_rate()) {
    return in_flight_.size() < limits.frames_on_unknown_path ? Instant::max() : Instant::min();
  }
  const PathEstimate::Sent& oldest = in_flight_.front().sent;
  const Duration bound = *path_.base_delay() + limits.allowance;
  if (path_.transmission_time(bytes_) >= bound) return Instant::min();
  const Duration overdue = std::max(limits.overdue_periods * frame_period_,
                                    2 * std::max(lateness_, lateness_before_) + frame_period_);
  return std::min(oldest.at + bound + path_.transmission_time(oldest.bytes),
                  next_acknowledgement_due() + overdue);
}

/// The path carries one frame after the other. So the oldest frame began transmission at the latest
/// acknowledgement, or when it was sent if that was later.
Instant ClientWindow::next_acknowledgement_due() const {
  const PathEstimate::Sent& oldest = in_flight_.front().sent;
  return std::max(acknowledged_at_, oldest.at + *path_.base_delay()) + path_.transmission_time(oldest.bytes);
}

Instant ClientWindow::wants_until() const {
  if (!in_sync_) return Instant::min();
  if (in_flight_.empty()) return Instant::max();
  if (drains_) return Instant::min();
  return std::min(room_until({allowance_, kOverdueWanted, kWantedOnUnknownPath}), path_.stale_at());
}

bool ClientWindow::can_accept(bool keyframe, Instant now) const {
  if (!in_sync_) return keyframe && in_flight_.empty();
  const Duration ahead =
      in_flight_.empty() ? Duration::zero() : path_.transmission_time(in_flight_.front().sent.bytes);
  const Duration allowance = kAllowanceForOthersFrames + std::min<Duration>(ahead, kMostForKeyframe);
  return now < room_until({std::max(allowance_, allowance), kOverdueAccepted, kFramesOnUnknownPath});
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
  measure_lateness(now);
  const auto arrived = known + 1;
  for (auto frame = in_flight_.begin(); frame != arrived; ++frame) {
    path_.acknowledged(frame->sent, now);
    bytes_ -= frame->sent.bytes;
    ++acknowledged_;
  }
  adapt_allowance(now);
  in_flight_.erase(in_flight_.begin(), arrived);
  drains_ &= !in_flight_.empty();
  return true;
}

std::optional<Instant> ClientWindow::waits_since() const {
  if (in_flight_.empty()) return std::nullopt;
  return in_flight_.front().sent.at;
}

void ClientWindow::measure_lateness(Instant now) {
  if (path_.delivery_rate()) {
    if (now - span_began_at_ > kLatenessSpan) {
      lateness_before_ = std::exchange(lateness_, Duration::zero());
      span_began_at_ = now;
    }
    lateness_ = std::max(lateness_, now - next_acknowledgement_due());
  }
  acknowledged_at_ = now;
}

void ClientWindow::adapt_allowance(Instant now) {
  const Duration queueing = path_.queueing_delay();
  if (!round_) round_ = {now + kRound, queueing};
  round_->least_queueing = std::min(round_->least_queueing, queueing);
  if (now < round_->ends_at) return;
  const Duration least = kFewestPeriods * frame_period_;
  if (round_->least_queueing > least) {
    // The delay did not fall when the allowance was reduced. Perhaps there is no queue, and the
    // path has become longer.
    drains_ = allowance_ == least;
    allowance_ = least;
  } else {
    allowance_ = std::min(allowance_ + frame_period_, kMostPeriods * frame_period_);
  }
  round_.reset();
}

}  // namespace copresence::wire
