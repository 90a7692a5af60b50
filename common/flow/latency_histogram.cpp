#include "common/flow/latency_histogram.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace copresence::flow {
namespace {

constexpr double kFirstMs = 1e-3;
const double kLogRatio = std::log(1.02);

}  // namespace

void LatencyHistogram::add(Duration duration) {
  const double ms = std::chrono::duration<double, std::milli>(duration).count();
  const double position = ms > kFirstMs ? std::log(ms / kFirstMs) / kLogRatio : 0.0;
  ++buckets_[static_cast<std::size_t>(std::min(position, double(kBuckets - 1)))];
  ++count_;
}

double LatencyHistogram::percentile_ms(double percent) const {
  if (count_ == 0) return 0.0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(percent / 100.0 * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (int i = 0; i < kBuckets; ++i) {
    seen += buckets_[static_cast<std::size_t>(i)];
    if (seen >= std::max<std::uint64_t>(wanted, 1)) return kFirstMs * std::exp((i + 0.5) * kLogRatio);
  }
  return kFirstMs * std::exp(kBuckets * kLogRatio);
}

LatencyHistogram LatencyHistogram::since(const LatencyHistogram& earlier) const {
  assert(count_ >= earlier.count_);
  LatencyHistogram later;
  for (std::size_t i = 0; i < buckets_.size(); ++i) later.buckets_[i] = buckets_[i] - earlier.buckets_[i];
  later.count_ = count_ - earlier.count_;
  return later;
}

}  // namespace copresence::flow
