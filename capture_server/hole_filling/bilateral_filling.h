#pragma once

// Fills holes with the mean of the depth around them, weighted by pixel distance alone (thesis
// section 3.2, second version). The method smears foreground into background and is kept for
// comparison.
// Thread: one thread at a time per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class BilateralFilling final : public HoleFiller {
 public:
  explicit BilateralFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// Sets each hole p to a mean over the measured pixels q around it: the sum of G(|p - q|) d(q),
  /// divided by the sum of G(|p - q|). G is a Gaussian and d is depth. The sums run along columns,
  /// then rows.
  /// Source: thesis appendix A.1 without the range kernel, since a hole has no depth to compare.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  DepthRangeUnits range_;
  std::vector<float> kernel_;  // Weights of the kernel's centre and of one side.
  // Sums of one row, with empty margins as wide as the kernel's radius.
  std::vector<float> column_sum_, column_weight_;
};

}  // namespace copresence::hole_filling
