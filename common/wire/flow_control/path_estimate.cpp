#include "common/wire/flow_control/path_estimate.h"

#include <algorithm>

namespace copresence::wire {
namespace {

constexpr std::chrono::seconds kRateWindow{2};
constexpr std::chrono::seconds kBaseWindow{10}, kWindowOfLargeFrame{2};
constexpr double kLargeFrame = 1.5;  // times the mean: a keyframe

double seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void PathEstimate::acknowledged(const Sent& frame, Instant now) {
  measure_rate(frame, now);
  measure_delay(frame, now);
  previous_ = frame;
  previous_acknowledged_at_ = now;
}

std::optional<double> PathEstimate::delivery_rate() const {
  if (rates_.empty()) return std::nullopt;
  return rates_.front().bytes_per_second;
}

Duration PathEstimate::transmission_time(std::size_t bytes) const {
  if (rates_.empty()) return Duration::zero();
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(static_cast<double>(bytes) / rates_.front().bytes_per_second));
}

std::optional<Duration> PathEstimate::base_delay() const {
  if (!base_) return std::nullopt;
  return std::max(base_->ack_delay - transmission_time(base_->bytes), Duration::zero());
}

Instant PathEstimate::stale_at() const {
  if (!base_) return Instant::max();
  return base_seen_at_ + (base_is_of_large_frame_ ? kWindowOfLargeFrame : kBaseWindow);
}

bool PathEstimate::is_stale(Instant now) const {
  return now >= stale_at();
}

void PathEstimate::measure_rate(const Sent& frame, Instant now) {
  Duration interval = std::max<Duration>(now - frame.at, std::chrono::milliseconds(1));
  if (frame.alone) {
    // The base delay is in this interval. It does no harm where a frame arrives before the next one is due.
    if (interval > tolerance_ / 2) return;
  } else {
    interval = std::max(
        {now - previous_acknowledged_at_, frame.at - previous_->at, Duration(std::chrono::milliseconds(1))});
  }
  const double rate = static_cast<double>(frame.bytes) / seconds(interval);
  const bool is_larger = rates_.empty() || rate >= rates_.front().bytes_per_second;
  const bool is_busy = queueing_ > tolerance_ / 4;
  if (!is_larger && !is_busy) return;
  while (!rates_.empty() && rates_.back().bytes_per_second <= rate) rates_.pop_back();
  rates_.push_back({now, rate});
  while (now - rates_.front().at > kRateWindow) rates_.pop_front();
}

void PathEstimate::measure_delay(const Sent& frame, Instant now) {
  const DelaySample sample{now - frame.at, frame.bytes};
  const auto without_transmission = [this](const DelaySample& of) {
    return std::max(of.ack_delay - transmission_time(of.bytes), Duration::zero());
  };
  // The rate may be understated, and then a large frame's transmission is overstated.
  const bool is_large = mean_bytes_ > 0 && static_cast<double>(frame.bytes) > kLargeFrame * mean_bytes_;
  mean_bytes_ = mean_bytes_ > 0 ? mean_bytes_ + (static_cast<double>(frame.bytes) - mean_bytes_) / 16
                                : static_cast<double>(frame.bytes);
  const auto take = [&](bool is_of_large_frame) {
    base_ = sample;
    base_is_of_large_frame_ = is_of_large_frame;
    base_seen_at_ = now;
  };
  if (!base_) take(true);  // the first frame is a keyframe
  const Duration excess = without_transmission(sample) - *base_delay();
  const bool corrects_large_frame =
      base_is_of_large_frame_ && sample.ack_delay <= base_->ack_delay + tolerance_ / 8;
  if (!is_large && (excess <= Duration::zero() || corrects_large_frame || (frame.alone && is_stale(now)))) {
    take(false);
  } else if (frame.alone && excess > tolerance_) {
    take(is_large);
    rates_.clear();  // another path than before
  } else if (!is_large && excess <= tolerance_ / 2) {
    base_seen_at_ = now;
  }
  queueing_ = std::max(without_transmission(sample) - *base_delay(), Duration::zero());
}

}  // namespace copresence::wire
