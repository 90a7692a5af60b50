#pragma once

// Two median passes over what was measured. The first closes enclosed holes on one surface from a large
// window, the second what is left, and rough spots of the first, from a small one. Thread: one thread at a
// time per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class MedianFilling final : public HoleFiller {
 public:
  explicit MedianFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// The median is of the pixels that hold depth; the lower one of an even number.
  /// Source   Maimone and Fuchs 2011: a hole is filled from the large window where the window's depths differ
  /// little,
  ///          enough of it holds depth, and enough of its rim does, so that silhouettes do not grow. Their
  ///          second pass also smooths measured depth; this one leaves it alone.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  /// How a pass judges a window.
  struct Window {
    int radius;
    int enough;      ///< pixels with depth
    int enough_rim;  ///< of them on the window's rim
    float widest;    ///< nearest minus farthest, steps
  };
  void pass(const Window& window, RgbdFrame& frame);
  void load(const DepthImage& depth);
  const std::uint16_t* padded(int x, int y) const;

  int width_, height_;
  float steps_times_units_;
  DepthRangeUnits range_;
  int stride_;
  std::vector<std::uint16_t> depths_;  // a copy with empty margins
};

}  // namespace copresence::hole_filling
