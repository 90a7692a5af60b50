#include "common/wire/client_window.h"

#include <algorithm>
#include <cassert>

namespace copresence::wire {
namespace {

constexpr std::chrono::milliseconds kRound{500};

}  // namespace

void ClientWindow::sent(std::uint64_t sequence, std::size_t bytes, Instant now) {
  assert(has_room());
  in_flight_.push_back({sequence, bytes, now});
  bytes_ += bytes;
  in_step_ = true;
}

void ClientWindow::skip(std::uint64_t frames) {
  if (frames == 0) return;
  skipped_ += frames;
  in_step_ = false;
}

bool ClientWindow::acknowledge(std::uint64_t sequence, Instant now) {
  const auto known = std::find_if(in_flight_.begin(), in_flight_.end(),
                                  [sequence](const Frame& frame) { return frame.sequence == sequence; });
  if (known == in_flight_.end()) return false;
  learn(now - known->sent_at, now);
  const auto arrived = known + 1;
  for (auto frame = in_flight_.begin(); frame != arrived; ++frame) bytes_ -= frame->bytes;
  in_flight_.erase(in_flight_.begin(), arrived);
  return true;
}

void ClientWindow::learn(Duration lag, Instant now) {
  smallest_lag_ = std::min(smallest_lag_.value_or(lag), lag);
  if (!round_) round_ = {now + kRound, lag};
  round_->smallest_lag = std::min(round_->smallest_lag, lag);
  if (now < round_->ends_at) return;

  if (round_->smallest_lag > *smallest_lag_ + 2 * frame_period_) {
    // As many as the path itself holds, the one that is being carried and the one that is next.
    const auto path = static_cast<std::size_t>(*smallest_lag_ / frame_period_);
    limit_ = std::min(limit_, path + 2);
  } else {
    limit_ = std::min(limit_ + 1, kFrames);
  }
  round_.reset();
}

}  // namespace copresence::wire
