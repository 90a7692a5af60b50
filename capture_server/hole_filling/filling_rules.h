#pragma once

// The numbers that all fillers share, so that CPU and GL agree and docs/internals/hole_filling.md has one place to
// quote.
//
// Inside this room depth is measured in disparity steps: s = disparity constant / z (DepthNoise). One step is the distance between
// neighbouring depth levels of the sensor wherever it is measured, so one threshold serves near and far; and
// planes are exactly linear in s over the image, which plain depth is not. Larger is nearer; 0 means no
// depth.

#include "common/frame/depth_unit.h"

namespace copresence::hole_filling {

/// Steps times units of depth: s = steps_times_units(unit, noise) / depth, and back.
constexpr float steps_times_units(DepthUnit unit, const DepthNoise& noise) {
  return static_cast<float>(noise.disparity_constant_m / metres_per_unit(unit));
}

/// A hole is closed where measured depth lies on both its sides in its row or in its column, at most this
/// many holes apart. Widest occlusion shadow of a Kinect: 43.5 px m (1 / 1 m - 1 / 4 m) = 33 px.
constexpr int kWidestGapPx = 40;
/// At the image's border depth on one side is enough, for so many holes: a Kinect v1 never measures its last eight
/// columns, and planes reach that far.
constexpr int kWidestAtBorderPx = 12;

constexpr int kCellPx = 4;            ///< edge of the cells on which wide holes are reasoned about
constexpr int kReachCells = 12;       ///< how far a hole looks for measured cells, each of eight ways
constexpr int kCellEnough = 5;        ///< measured pixels, of 16, that make a cell worth looking at
constexpr float kOneSurface = 6;      ///< steps: a cell whose depths differ by more holds two surfaces
constexpr float kLinked = 5;          ///< steps: guesses that differ by less belong to one surface
constexpr int kWorthPixels = 8;       ///< measured pixels in sight that make a surface count
constexpr float kSteepest = 1;        ///< steps per pixel: steeper differences are edges, not slopes
constexpr float kSameSurface = 3;     ///< steps: measured pixels this near to a guess correct it
constexpr float kGuessWeight = 0.5f;  ///< of the guess against the measured pixels that correct it
constexpr int kWindowPx = 2;          ///< radius of the window in which measured pixels correct a guess
constexpr float kShadowPxPerStep =
    0.16f;  ///< width of a shadow: f b = 43.5 px m, and a third for the slope of things
constexpr float kShadowSlackPx = 2;  ///< and its ragged rim
constexpr float kColorSigma = 24;    ///< of 255, Euclidean over the channels

// The simpler methods.
constexpr int kMedianWindowPx = 4;        ///< radius of the first pass
constexpr int kMedianSmallWindowPx = 2;   ///< and of the second
constexpr int kMedianEnoughPercent = 35;  ///< of the first window's pixels that must hold depth
constexpr int kMedianRimPercent = 45;     ///< of the window's outermost pixels: whether the hole is enclosed
constexpr float kMedianSpread = 12;    ///< steps: wider windows hold an edge and are left to the second pass
constexpr int kBilateralWindowPx = 5;  ///< radius
constexpr float kBilateralSigmaPx = 2.5f;  ///< half the radius
constexpr float kBilateralEnough = 0.15f;  ///< of the window's weight that must hold depth

}  // namespace copresence::hole_filling
