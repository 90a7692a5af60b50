#include "common/wire/flow_control/encoder_demand.h"

#include <algorithm>

namespace copresence::wire {
namespace {

constexpr std::chrono::seconds kBetweenKeyframes{1};
constexpr std::chrono::seconds kLongestPause{3};
constexpr double kShareOfKeyframes = 0.05;

}  // namespace

void EncoderDemand::Clients::add(const ClientWindow& window) {
  wants_until_ = std::max(wants_until_, window.wants_until());
  in_sync_ |= window.in_sync();
  if (window.awaits_keyframe()) (window.fell_behind() ? fell_behind_ : joins_) = true;
}

bool EncoderDemand::may_request_keyframe(Instant now) const {
  if (keyframe_taken_at_ && now - *keyframe_taken_at_ < kBetweenKeyframes) return false;
  if (clients_.joins_) return true;
  return (clients_.fell_behind_ || requested_) && (!clients_.in_sync_ || now >= next_for_slow_clients_);
}

bool EncoderDemand::wants_frame(Instant now) const {
  const bool only_keyframe = clients_.joins_ || clients_.fell_behind_;
  return now < clients_.wants_until_ || (only_keyframe && (promised_ || may_request_keyframe(now)));
}

bool EncoderDemand::take_keyframe_request(Instant now) {
  if (!may_request_keyframe(now)) return false;
  keyframe_taken_at_ = now;
  promised_ = true;
  return true;
}

void EncoderDemand::sent(bool keyframe, std::size_t bytes, Instant now) {
  const double size = static_cast<double>(bytes);
  if (!keyframe) {
    mean_bytes_ = mean_bytes_ > 0 ? mean_bytes_ + (size - mean_bytes_) / 32 : size;
    return;
  }
  requested_ = promised_ = false;
  const double extra_frames = mean_bytes_ > 0 ? std::max(size / mean_bytes_ - 1, 0.0) : 0;
  const auto pause = std::chrono::duration_cast<Duration>(extra_frames / kShareOfKeyframes *
                                                          std::chrono::duration<double>(frame_period_));
  next_for_slow_clients_ = now + std::min<Duration>(pause, kLongestPause);
}

}  // namespace copresence::wire
