#pragma once

// Statistics of the difference between original and decoded depth, over measured pixels.

#include <cstdint>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::depth_bench {

class DepthError {
 public:
  explicit DepthError(DepthUnit unit)
      : mm_per_unit_(metres_per_unit(unit) * 1000), histogram_(kBins), steps_(kBins) {}

  /// Adds a frame. Requires images of one size.
  void add(const DepthImage& depth, const StateImage& states, const DepthImage& back,
           const StateImage& states_back);

  double rmse_mm() const;
  double rmse_steps() const;
  double mae_mm() const;
  double percentile_mm(double share) const;     ///< Has a resolution of 0.01 mm and a limit of 655 mm.
  double percentile_steps(double share) const;  ///< Has a resolution of 0.01 disparity steps.
  double max_mm() const { return max_mm_; }
  /// Share of pixels with an error above 3 disparity steps + 1 mm.
  double percent_beyond_3_steps() const { return percent(beyond_3_steps_); }
  double percent_beyond_100mm() const { return percent(beyond_100mm_); }
  /// Share of pixels at depth edges that are more than 5 disparity steps from both sides of the
  /// edge. They are called flying pixels.
  double percent_flying() const {
    return edges_ ? 100.0 * static_cast<double>(flying_) / static_cast<double>(edges_) : 0;
  }
  std::uint64_t hole_flips() const { return flips_; }

 private:
  static constexpr std::size_t kBins = 65536;
  static constexpr double kBin = 0.01;

  void add_edges(const DepthImage& depth, const DepthImage& back);
  double percentile(const std::vector<std::uint64_t>& histogram, double share) const;
  double percent(std::uint64_t count) const {
    return pixels_ ? 100.0 * static_cast<double>(count) / static_cast<double>(pixels_) : 0;
  }

  double mm_per_unit_;
  std::vector<std::uint64_t> histogram_, steps_;  // Bins of kBin mm and of kBin steps.
  double sum_mm_ = 0, sum_mm2_ = 0, sum_steps2_ = 0, max_mm_ = 0;
  std::uint64_t pixels_ = 0, beyond_3_steps_ = 0, beyond_100mm_ = 0, flips_ = 0, edges_ = 0, flying_ = 0;
};

}  // namespace copresence::depth_bench
