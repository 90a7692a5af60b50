#pragma once

// Two median passes over the measured depth. The first pass, with a large window, fills holes that
// are enclosed by one surface. The second pass, with a small window, fills the other holes and
// smooths what the first pass filled.
// Thread: one thread at a time per object.

#include <vector>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

class MedianFilling final : public HoleFiller {
 public:
  explicit MedianFilling(const FrameFormat& format);

  std::string_view name() const override { return "cpu"; }

  /// Sets each hole to the median of the window's pixels with depth. The lower of two middle values
  /// is used.
  /// Source: Maimone and Fuchs 2011. The large window fills a hole if its depths differ little and
  /// if enough pixels of the window and of its rim hold depth. The condition on the rim keeps
  /// silhouettes from growing. The paper's second pass also smooths measured depth; this one does
  /// not.
  Result<void> fill(RgbdFrame& frame) override;

 private:
  /// The conditions under which a window fills a hole.
  struct Window {
    int radius;
    int enough;      ///< Minimum number of pixels with depth.
    int enough_rim;  ///< Minimum number of pixels with depth on the window's rim.
    float widest;    ///< Largest difference between depths, in steps.
  };
  void pass(const Window& window, RgbdFrame& frame);
  void load(const DepthImage& depth);
  const std::uint16_t* padded(int x, int y) const;

  int width_, height_;
  float steps_times_units_;
  DepthRangeUnits range_;
  int stride_;
  std::vector<std::uint16_t> depths_;  // A copy of the depth image with empty margins.
};

}  // namespace copresence::hole_filling
