#pragma once

// Every camera's map to the reference camera's colours, kept steady over time. Pairs of cameras that overlap
// are fitted one by one, the best overlaps chain every camera to the reference, and joint least squares over
// all pairs spreads what is left (thesis 2.6.2, which knows two cameras).
//
// Thread: one thread at a time. A round of two cameras takes a few milliseconds: call it off the render
// thread.

#include <optional>
#include <span>
#include <vector>

#include "common/frame/rgbd_frame.h"
#include "render_client/color_matching/color_fit.h"
#include "render_client/color_matching/color_pairs.h"

namespace copresence::color_matching {

/// The maps from `frames`, the first of which is the reference, or nothing for a camera that no chain of
/// overlaps joins to it. An entry without colour or without a place (a null frame) takes no part.
std::vector<std::optional<ColorCorrection>> match_colors(std::span<const PosedFrame> frames);

/// What to show while matches come in: the first one at once, later ones eased in, since exposure changes
/// over seconds and a fit's noise must not show as flicker; and the last one where the overlap is gone.
class SteadyMaps {
 public:
  explicit SteadyMaps(std::size_t cameras) : maps_(cameras) {}

  /// Takes in what a match has found, `elapsed` after the one before.
  void follow(std::span<const std::optional<ColorCorrection>> found, Duration elapsed);

  bool is_known(std::size_t camera) const { return maps_[camera].has_value(); }

  /// Identity where nothing is known.
  ColorCorrection map(std::size_t camera) const {
    return maps_[camera].value_or(ColorCorrection::Identity());
  }

 private:
  std::vector<std::optional<ColorCorrection>> maps_;
};

}  // namespace copresence::color_matching
