#pragma once

// Finds the colour correction of every camera towards the reference camera, and keeps it steady
// over time. First each pair of overlapping cameras is fitted. Then the best overlaps chain every
// camera to the reference. Joint least squares over all pairs distributes the remaining error.
// Thesis 2.6.2 does this for two cameras.
//
// Thread: one thread at a time. Matching two cameras takes a few milliseconds, so do not call it on
// the render thread.

#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/color_matching/color_fit.h"
#include "render_client/color_matching/color_pairs.h"

namespace copresence::color_matching {

/// The corrections of `frames`, the first of which is the reference. Nothing for a camera that no
/// chain of overlaps leads to. A null frame or one without colour takes no part.
std::vector<std::optional<ColorCorrection>> match_colors(std::span<const PosedFrame> frames);

/// Corrections filtered over time. The first one is used at once. Later ones are eased in: exposure
/// changes over seconds, and the noise of a fit must not become flicker. Without overlap the last
/// correction stays.
class SteadyCorrections {
 public:
  explicit SteadyCorrections(std::size_t cameras) : corrections_(cameras) {}

  /// Adds the result of a match, `elapsed` after the one before.
  void follow(std::span<const std::optional<ColorCorrection>> found, Duration elapsed);

  bool is_known(std::size_t camera) const { return corrections_[camera].has_value(); }

  /// Identity if nothing is known.
  ColorCorrection correction(std::size_t camera) const {
    return corrections_[camera].value_or(ColorCorrection::Identity());
  }

 private:
  std::vector<std::optional<ColorCorrection>> corrections_;
};

}  // namespace copresence::color_matching
