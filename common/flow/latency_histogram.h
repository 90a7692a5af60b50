#pragma once

// Computes percentiles of a duration over a run, in constant memory. Thread: distinct objects are
// independent.

#include <array>
#include <cstdint>

#include "common/frame/rgbd_frame.h"

namespace copresence::flow {

/// Counts durations from 1 microsecond to 100 s in logarithmic buckets that are 2 % wide.
/// Percentiles are therefore accurate to 1 %.
class LatencyHistogram {
 public:
  void add(Duration duration);
  std::uint64_t count() const { return count_; }

  /// Milliseconds below which `percent` (0 to 100) of the durations lie; 0 if there are none.
  double percentile_ms(double percent) const;

  /// Returns the durations that were added after the copy `earlier` of this histogram was made.
  LatencyHistogram since(const LatencyHistogram& earlier) const;

 private:
  static constexpr int kBuckets = 940;
  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
};

}  // namespace copresence::flow
