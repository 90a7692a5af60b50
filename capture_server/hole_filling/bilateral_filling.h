#pragma once

// Holes filled with the mean of the depth around them, weighted by pixel distance alone (thesis 3.2, second
// version). It smears foreground into background; it is here to compare with. Thread: one thread at a time
// per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class BilateralFilling final : public HoleFiller {
 public:
  explicit BilateralFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// d(p) = sum over measured q of G(|p - q|) d(q), divided by the sum of G(|p - q|): a normalised
  /// convolution, done first along columns, then along rows. Source   thesis A.1 without the range kernel,
  /// which a hole has no depth for.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  DepthRangeUnits range_;
  std::vector<float> kernel_;                      // one half and the middle
  std::vector<float> column_sum_, column_weight_;  // of one row, with a margin of the kernel's radius
};

}  // namespace copresence::hole_filling
