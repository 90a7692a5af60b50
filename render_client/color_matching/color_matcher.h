#pragma once

// Finds the correction from every camera's colours to those of the reference camera. First a
// correction is fitted to each pair of overlapping cameras. Then the best overlaps chain every
// camera to the reference. Joint least squares over all pairs distributes the remaining error. The
// thesis (2.6.2) does this for two cameras. Thread: one thread at a time per object. Matching two
// cameras takes a few milliseconds, so do not call match_colors() on the render thread.

#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/color_matching/color_fit.h"
#include "render_client/color_matching/color_pairs.h"

namespace copresence::color_matching {

/// Returns the corrections of the cameras. The first camera is the reference. A camera without a
/// chain of overlaps to the reference gets nothing. Frames without colour are ignored.
std::vector<std::optional<ColorCorrection>> match_colors(std::span<const PosedFrame> frames);

/// Filters the corrections over time, so that the noise of a fit does not become flicker. The first
/// correction of a camera is used at once. Later corrections are reached gradually, within seconds.
/// Without overlap, the last correction stays.
class SteadyCorrections {
 public:
  explicit SteadyCorrections(std::size_t cameras) : corrections_(cameras) {}

  /// Adds a result of match_colors(). `elapsed` is the time since the previous result.
  void follow(std::span<const std::optional<ColorCorrection>> found, Duration elapsed);

  bool is_known(std::size_t camera) const { return corrections_[camera].has_value(); }

  /// Returns the identity if no correction is known.
  ColorCorrection correction(std::size_t camera) const {
    return corrections_[camera].value_or(ColorCorrection::Identity());
  }

 private:
  std::vector<std::optional<ColorCorrection>> corrections_;
};

}  // namespace copresence::color_matching
