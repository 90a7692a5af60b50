#pragma once

// The default filler, on the CPU: joint bilateral filling by pixel, depth and colour distance,
// which does not bridge surfaces. See docs/internals/hole_filling.md.
// Thread: one thread at a time per object.

#include "capture_server/hole_filling/cells.h"
#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class JointFilling final : public HoleFiller {
 public:
  explicit JointFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }
  Result<void> fill(RgbdFrame& frame) override;

 private:
  void fill_cell(int column, int row, RgbdFrame& frame);

  float steps_times_units_;
  DepthRangeUnits range_;
  Image<std::uint8_t> fillable_;
  Cells cells_;
};

}  // namespace copresence::hole_filling
