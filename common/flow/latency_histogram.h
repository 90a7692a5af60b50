#pragma once

// Percentiles of a duration over a run, in bounded memory.
// Thread: a value; guard it yourself.

#include <array>
#include <cstdint>

#include "common/frame/rgbd_frame.h"

namespace copresence::flow {

/// Durations in logarithmic buckets 2 % wide, from 1 microsecond to 100 s: percentiles are good to 1 %.
class LatencyHistogram {
 public:
  void add(Duration duration);
  std::uint64_t count() const { return count_; }

  /// Milliseconds below which `percent` of the durations lie; 0 when there are none. 0 <= percent <= 100.
  double percentile_ms(double percent) const;

 private:
  static constexpr int kBuckets = 940;
  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
};

}  // namespace copresence::flow
