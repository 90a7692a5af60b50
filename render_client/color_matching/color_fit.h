#pragma once

// The map that takes one camera's colours to another's, from pairs of which many may be wrong: gain and offset per
// channel by RANSAC, then all twelve numbers by least squares over the pairs that agree (thesis 2.6.2; Fischler and
// Bolles 1981). Thread: pure; the same pairs give the same map.

#include <optional>
#include <span>
#include <vector>

#include "render_client/color_matching/color_correction.h"

namespace copresence::color_matching {

/// Fewer pairs than this say nothing.
inline constexpr std::size_t kFewestPairs = 60;

struct ColorFit {
  ColorCorrection map;
  std::vector<ColorPair> inliers;  ///< at most kMostInliers of those that agree, spread over all
  std::size_t agreeing = 0;        ///< how many agree
  double rms = 0;                  ///< of their channels, 0 to 1
};
inline constexpr std::size_t kMostInliers = 1500;

/// Fails (nothing) with fewer than kFewestPairs pairs, or where less than a third of them agree on one map whose gains
/// lie between 0.4 and 2.5.
std::optional<ColorFit> fit_color_map(std::span<const ColorPair> pairs);

/// Least squares over all twelve numbers, held towards `near` by the weight of a fraction of the pairs: colours that a
/// scene does not show, a grey room's reds, keep what `near` says of them. Requires pairs.
ColorCorrection refine_color_map(std::span<const ColorPair> pairs, const ColorCorrection& near);

}  // namespace copresence::color_matching
