#pragma once

// Fills holes with the mean of the depth around them, weighted by pixel distance alone (thesis 3.2,
// second version). It smears foreground into background. It is kept for comparison. Thread: one
// thread at a time per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class BilateralFilling final : public HoleFiller {
 public:
  explicit BilateralFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// d(p) = sum over measured q of G(|p - q|) d(q), divided by the sum of G(|p - q|): a normalised
  /// convolution, first along columns, then along rows.
  /// Source   thesis A.1 without the range kernel: a hole has no depth to compare.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  DepthRangeUnits range_;
  std::vector<float> kernel_;                      // the centre and one half
  std::vector<float> column_sum_, column_weight_;  // of one row, with margins of the kernel's radius
};

}  // namespace copresence::hole_filling
