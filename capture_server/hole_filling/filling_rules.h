#pragma once

// Constants of all fillers, shared by CPU and GL and quoted by docs/internals/hole_filling.md.
//
// The fillers measure depth in disparity steps: s = disparity constant / z (DepthNoise). One step
// is the distance between neighbouring depth levels of the sensor at every depth, so one threshold
// serves near and far. Planes are exactly linear in s over the image, which plain depth is not.
// Larger is nearer; 0 means no depth.

#include "common/frame/depth_unit.h"

namespace copresence::hole_filling {

/// The product of steps and depth in units: s = steps_times_units(unit, noise) / depth, and the
/// other way round.
constexpr float steps_times_units(DepthUnit unit, const DepthNoise& noise) {
  return static_cast<float>(noise.disparity_constant_m / metres_per_unit(unit));
}

/// A hole is closed if measured depth lies on both sides of it in its row or column, at most this
/// many holes apart. Widest occlusion shadow of a Kinect: 43.5 px m (1 / 1 m - 1 / 4 m) = 33 px.
constexpr int kWidestGapPx = 40;
/// At the image's border, depth on one side is enough, up to this many holes. A Kinect v1 never
/// measures its last eight columns, and planes extend that far.
constexpr int kWidestAtBorderPx = 12;

constexpr int kCellPx = 4;         ///< edge of the cells from which wide holes are filled
constexpr int kReachCells = 12;    ///< reach of the search for measured cells, in each of eight directions
constexpr int kCellEnough = 5;     ///< measured pixels, of 16, that a cell needs to be used
constexpr float kOneSurface = 6;   ///< steps: a cell whose depths differ by more holds two surfaces
constexpr float kLinked = 5;       ///< steps: candidates that differ by less belong to one surface
constexpr int kWorthPixels = 8;    ///< measured pixels that a candidate surface needs
constexpr float kSteepest = 1;     ///< steps per pixel: steeper differences are edges, not slopes
constexpr float kSameSurface = 3;  ///< steps: measured pixels this close to a candidate correct it
constexpr float kCandidateWeight =
    0.5f;                     ///< weight of the candidate against the measured pixels that correct it
constexpr int kWindowPx = 2;  ///< radius of the window in which measured pixels correct a candidate
constexpr float kShadowPxPerStep =
    0.16f;                           ///< width of a shadow: f b = 43.5 px m, plus a third for sloped surfaces
constexpr float kShadowSlackPx = 2;  ///< added for the shadow's ragged rim
constexpr float kColorSigma = 24;    ///< of 255, Euclidean over the channels

// Median and bilateral filling.
constexpr int kMedianWindowPx = 4;        ///< radius of the first pass
constexpr int kMedianSmallWindowPx = 2;   ///< radius of the second pass
constexpr int kMedianEnoughPercent = 35;  ///< of the first window's pixels that must hold depth
constexpr int kMedianRimPercent =
    45;  ///< of the window's outermost pixels that must hold depth, so that the hole is enclosed
constexpr float kMedianSpread =
    12;  ///< steps: a window with a larger range holds an edge and is left to the second pass
constexpr int kBilateralWindowPx = 5;      ///< radius
constexpr float kBilateralSigmaPx = 2.5f;  ///< half the radius
constexpr float kBilateralEnough = 0.15f;  ///< of the window's weight that must hold depth

}  // namespace copresence::hole_filling
