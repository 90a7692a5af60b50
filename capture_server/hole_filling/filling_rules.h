#pragma once

// Constants of all hole filling methods, explained in docs/internals/hole_filling.md.
//
// The methods measure depth in disparity steps: s = c / z, where z is depth and c the disparity
// constant (DepthNoise). Neighbouring depth levels of the sensor are one step apart at every
// distance, so one threshold serves near and far. Planes are exactly linear in s over the image,
// but not in z. A larger s is nearer, and 0 means no depth.

#include "common/frame/depth_unit.h"

namespace copresence::hole_filling {

/// The factor between steps and depth in units: steps = factor / depth and depth = factor / steps.
constexpr float steps_times_units(DepthUnit unit, const DepthNoise& noise) {
  return static_cast<float>(noise.disparity_constant_m / metres_per_unit(unit));
}

/// A hole is filled if its row or column has measured depth on both sides, at most this many holes
/// apart. The widest occlusion shadow of a Kinect is 43.5 px m * (1 / 1 m - 1 / 4 m) = 33 px.
constexpr int kWidestGapPx = 40;
/// At the image's border, depth on one side is enough for up to this many holes. A Kinect v1 never
/// measures its last eight columns, and planes can be extended that far.
constexpr int kWidestAtBorderPx = 12;

constexpr int kCellPx = 4;        ///< Edge length of the cells from which wide holes are filled.
constexpr int kReachCells = 12;   ///< Reach of the search for measured cells in each direction, in cells.
constexpr int kCellEnough = 5;    ///< A usable cell has at least this many measured pixels of 16.
constexpr float kOneSurface = 6;  ///< In steps. A cell with a larger depth range holds two surfaces.
constexpr float kLinked = 5;      ///< In steps. Candidate surfaces that differ by less belong to one surface.
constexpr int kWorthPixels = 8;   ///< Minimum number of measured pixels for a candidate surface.
constexpr float kSteepest = 1;    ///< In steps per pixel. Steeper differences are edges, not slopes.
/// In steps. Measured pixels with a smaller distance to a candidate correct it.
constexpr float kSameSurface = 3;
/// Weight of a candidate; the measured pixels that correct it have weight 1 or less.
constexpr float kCandidateWeight = 0.5f;
constexpr int kWindowPx = 2;  ///< Radius of the window in which measured pixels correct a candidate.
/// Width of an occlusion shadow per step: 43.5 px m / 351.3 m, plus a third for sloped surfaces.
constexpr float kShadowPxPerStep = 0.16f;
constexpr float kShadowSlackPx = 2;  ///< Pixels added to a shadow's width for its ragged rim.
/// Of 255. Standard deviation of colour distance, Euclidean over the channels.
constexpr float kColorSigma = 24;

// The following constants are for median and bilateral filling.
constexpr int kMedianWindowPx = 4;        ///< Radius of the first pass.
constexpr int kMedianSmallWindowPx = 2;   ///< Radius of the second pass.
constexpr int kMedianEnoughPercent = 35;  ///< Share of the first window's pixels that must hold depth.
/// Share of the window's outermost pixels that must hold depth, so that the hole is enclosed.
constexpr int kMedianRimPercent = 45;
/// In steps. A window with a larger depth range holds an edge and is left to the second pass.
constexpr float kMedianSpread = 12;
constexpr int kBilateralWindowPx = 5;      ///< Radius of the window.
constexpr float kBilateralSigmaPx = 2.5f;  ///< Standard deviation of the Gaussian weights.
constexpr float kBilateralEnough = 0.15f;  ///< Share of the window's weight that must hold depth.

}  // namespace copresence::hole_filling
