#include "render_client/session/replay_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace copresence::session {
namespace {

using Seconds = std::chrono::duration<double>;

std::string minutes_and_seconds(Seconds time) {
  const auto seconds = static_cast<long>(time.count());
  return fmt::format("{}:{:02}", seconds / 60, seconds % 60);
}

}  // namespace

ReplayControl::ReplayControl(Time begin, Time end, std::function<std::optional<Time>(Time)> next_frame_after)
    : begin_(begin), end_(end), next_frame_after_(std::move(next_frame_after)), position_(begin) {}

bool ReplayControl::apply(ReplayCommand command) {
  const auto jump_to = [this](auto position) {
    position_ = std::clamp<decltype(position_)>(position, begin_, end_);
    return true;
  };
  switch (command) {
    case ReplayCommand::kPause:
      is_paused_ = !is_paused_;
      return false;
    case ReplayCommand::kStep:
      is_paused_ = true;
      if (const auto next = next_frame_after_(std::chrono::floor<Time>(position_))) position_ = *next;
      return false;
    case ReplayCommand::kSlower:
      speed_ = std::max(speed_ / 2, kSlowest);
      return false;
    case ReplayCommand::kFaster:
      speed_ = std::min(speed_ * 2, kFastest);
      return false;
    case ReplayCommand::kBack:
      return jump_to(position_ - kJump);
    case ReplayCommand::kForward:
      return jump_to(position_ + kJump);
    case ReplayCommand::kRestart:
      return jump_to(begin_);
  }
  return false;
}

Time ReplayControl::position(Instant now) {
  if (!is_paused_ && last_) position_ += speed_ * (now - *last_);
  last_ = now;
  position_ = std::min<decltype(position_)>(position_, end_);
  return std::chrono::floor<Time>(position_);
}

std::string ReplayControl::text() const {
  const bool is_at_end = position_ >= end_;
  return fmt::format("{} of {}{}{}", minutes_and_seconds(position_ - begin_),
                     minutes_and_seconds(end_ - begin_),
                     is_at_end    ? ", end"
                     : is_paused_ ? ", paused"
                                  : "",
                     speed_ == 1 ? "" : fmt::format(", {}x", speed_));
}

}  // namespace copresence::session
