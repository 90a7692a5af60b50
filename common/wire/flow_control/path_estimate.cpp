#include "common/wire/flow_control/path_estimate.h"

#include <algorithm>

namespace copresence::wire {
namespace {

constexpr std::chrono::seconds kRateWindow{2}, kBaseWindow{10};
// A frame larger than the mean size by this factor is a keyframe.
constexpr double kLargeFrame = 1.5;
// Intervals or rates that differ by a smaller factor count as equal.
constexpr double kSame = 1.1;

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
  return base_seen_at_ + kBaseWindow;
}

bool PathEstimate::is_stale(Instant now) const {
  return now >= stale_at();
}

void PathEstimate::measure_rate(const Sent& frame, Instant now) {
  Duration interval = std::max<Duration>(now - frame.at, std::chrono::milliseconds(1));
  bool limited_by_path = false;
  if (frame.alone) {
    // This interval also includes the base delay, so the rate is underestimated. The error does not
    // matter if the acknowledgement arrives before the next frame is due.
    if (interval > tolerance_ / 2) return;
  } else {
    const Duration sent_apart = frame.at - previous_->at,
                   acknowledged_apart = now - previous_acknowledged_at_;
    interval = std::max({acknowledged_apart, sent_apart, Duration(std::chrono::milliseconds(1))});
    limited_by_path = acknowledged_apart > kSame * sent_apart;
  }
  const double rate = static_cast<double>(frame.bytes) / seconds(interval);
  const bool is_larger = rates_.empty() || rate >= rates_.front().bytes_per_second;
  const bool is_busy = queueing_ > tolerance_ / 4;
  if (!is_larger && !is_busy) return;
  while (!rates_.empty() && rates_.back().bytes_per_second <= rate) {
    // A sender that waits for acknowledgements is still limited by the path.
    limited_by_path |= rates_.back().limited_by_path && rate < kSame * rates_.back().bytes_per_second;
    rates_.pop_back();
  }
  rates_.push_back({now, rate, limited_by_path});
  while (now - rates_.front().at > kRateWindow) rates_.pop_front();
}

void PathEstimate::measure_delay(const Sent& frame, Instant now) {
  const DelaySample sample{now - frame.at, frame.bytes};
  const auto without_transmission = [this](const DelaySample& of) {
    return std::max(of.ack_delay - transmission_time(of.bytes), Duration::zero());
  };
  const double bytes = static_cast<double>(frame.bytes);
  const bool is_large = !base_ || bytes > kLargeFrame * mean_bytes_;
  mean_bytes_ = base_ ? mean_bytes_ + (bytes - mean_bytes_) / 16 : bytes;
  const auto take = [&] {
    base_ = sample;
    base_is_of_large_frame_ = is_large;
    base_seen_at_ = now;
  };
  if (!base_) take();
  const Duration excess = without_transmission(sample) - *base_delay();
  const bool rate_is_known = !rates_.empty() && rates_.front().limited_by_path;
  const bool corrects_large_frame =
      base_is_of_large_frame_ && !rate_is_known && sample.ack_delay <= base_->ack_delay + tolerance_ / 2;
  if (!is_large && (excess <= Duration::zero() || corrects_large_frame || (frame.alone && is_stale(now)))) {
    take();
  } else if (frame.alone && excess > tolerance_) {
    take();
    rates_.clear();  // The path has changed.
  } else if (!is_large && excess <= tolerance_ / 2) {
    base_seen_at_ = now;
  }
  queueing_ = std::max(without_transmission(sample) - *base_delay(), Duration::zero());
}

}  // namespace copresence::wire
