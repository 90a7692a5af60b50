#pragma once

// Two median passes over the measured depth. The first pass closes enclosed holes on one surface
// with a large window. The second closes the others, and rough spots of the first, with a small
// one. Thread: one thread at a time per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class MedianFilling final : public HoleFiller {
 public:
  explicit MedianFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// The median is that of the pixels with depth; of an even number it is the lower one.
  /// Source   Maimone and Fuchs 2011: the large window fills a hole if its depths differ little,
  ///          enough pixels hold depth, and enough pixels of its rim do, so that silhouettes do not
  ///          grow. Their second pass also smooths measured depth; this one does not.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  /// When a window may fill a hole.
  struct Window {
    int radius;
    int enough;      ///< pixels with depth
    int enough_rim;  ///< of these on the window's rim
    float widest;    ///< largest difference of depths, steps
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
