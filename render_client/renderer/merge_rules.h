#pragma once

// The rules both renderers follow, so that their pictures agree: which pixels join to a surface, what a
// fragment is worth, and which fragments of a view's pixel make its colour.
//
// Most of it is written in inverse depth w = 1/z (1/m, z along the source camera's axis): a sensor's depth
// levels are evenly spaced there (DepthNoise), a plane is an affine function of the pixel there, and so both
// tests below are linear.
//
// Surface   A camera's pixels are the vertices of a grid, pixel centres at whole coordinates. A triangle of
//           three neighbouring pixels is drawn when all three have depth and joined() holds. The quad (x, y)
//           to (x+1, y+1) is split from its top right to its bottom left corner. Where that diagonal does not
//           give two triangles, it is split along the other one if that gives two; else its single triangle
//           is drawn. A surface is drawn only from the side that the camera saw. Planar regions may be drawn
//           coarser, where all their pixels lie within kPlanarSteps of the plane, and a quad whose triangles
//           both show may be drawn as the one plane nearest to its corners.
// Fragment  Depth and texture coordinate are interpolated perspectively. A fragment has the state of the
//           pixel nearest to its texture coordinate, and that pixel's cell decides cos(theta).
// Merge     fragment_worth() and blend_weight(), below.
// Colour    Bilinear in the source image, clamped at its border, then the camera's color_matching, clamped to
//           0..1. A camera without colour shows the gray of shade_without_color().
// Stale     A camera whose opacity is below 1 is shown only where no live camera shows anything, at any
//           distance. Among themselves stale cameras are merged like others. Their colours are multiplied by
//           the opacity.
// Outlines  Where the nearest fragments of two neighbours in a row lie kOutlineSteps apart in inverse depth
//           along the eye's axis, each takes a kOutlineDivisor-th of its difference to the other's colour. An
//           outline lies somewhere within a pixel, so half covered is the best guess; it hides stair steps.
//
// Thread: pure functions.

#include <algorithm>
#include <cmath>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::renderer {

/// One step of the sensor in inverse depth, 1/m.
inline float inverse_step(const DepthNoise& noise) {
  return 1.0F / static_cast<float>(noise.disparity_constant_m);
}

/// Neighbours may differ by this many steps through noise and lossy coding...
inline constexpr float kGapSteps = 4.0F;
/// ...and by the tilt of the surface: metres of depth per metre across, tan(80 degrees).
inline constexpr float kMaxSlope = 5.7F;

/// A region is planar, and may be drawn as one, when no pixel is farther than this from its plane.
inline constexpr float kPlanarSteps = 2.0F;

/// Limits for one camera's surface, in inverse depth (1/m).
struct SurfaceLimits {
  /// `pixel_angle` is the angle between neighbouring pixels in radians: 1 / fx, times the grid's step in a
  /// mesh that takes only every second pixel.
  SurfaceLimits(const DepthNoise& noise, float pixel_angle)
      : gap(kGapSteps * inverse_step(noise)),
        slope(kMaxSlope * pixel_angle),
        planar(kPlanarSteps * inverse_step(noise)),
        curvature(inverse_step(noise)) {}

  float gap;    ///< that noise may open between neighbours
  float slope;  ///< times w: that the surface's slope may open between neighbours
  /// Distance of a pixel from the plane of its block of 4.
  float planar;
  /// Distance of that plane from the plane of the next larger block. Planes of 25 pixels are known to a quarter of a step
  /// at their corners.
  float curvature;
};

/// Whether three neighbouring pixels lie on one surface. Inverse depths, 1/m, all > 0.
inline bool joined(float a, float b, float c, const SurfaceLimits& limits) {
  const float nearest = std::max({a, b, c});
  const float farthest = std::min({a, b, c});
  return nearest - farthest <= limits.gap + limits.slope * farthest;
}

/// Tilts come from cells of this many pixels a side, the first at (0, 0): by least squares of w over the
/// cell's pixels with depth (its neighbours' first pixels may take part). Interpolated between the cells'
/// centres.
inline constexpr int kCell = 8;
/// Pixels a cell needs for that; a cell with fewer has kUnknownCosine.
inline constexpr int kCellPixels = 16;
inline constexpr float kUnknownCosine = 0.25F;

/// cos(theta) in (0, 1], theta between the surface's normal and the ray to it (the thesis takes the camera's
/// axis, figure 2.9, for which a level camera would find every floor worthless). `w` > 0 inverse depth in 1/m
/// at the cell's middle, `dw_dx`, `dw_dy` its change per unit of the ray (x, y, 1) there, that is, per pixel
/// times fx and fy.
inline float cos_theta(float w, float dw_dx, float dw_dy, float x, float y) {
  // The plane n.P = 1 has w = n.(x, y, 1), so n = (dw_dx, dw_dy, w - x dw_dx - y dw_dy), and n.ray is w
  // again.
  const float n_z = w - x * dw_dx - y * dw_dy;
  const float normal = std::sqrt(dw_dx * dw_dx + dw_dy * dw_dy + n_z * n_z);
  const float ray = std::sqrt(x * x + y * y + 1.0F);
  return std::min(1.0F, w / (normal * ray));
}

/// What a filled pixel is worth beside a measured one.
inline constexpr float kFilledWorth = 0.25F;

/// How far, in metres along the eye's axis, a fragment may lie behind the nearest one and still be the same
/// surface (thesis 2.6.1): the sum of both fragments' uncertainty_m(). It is kRangeSigmas of the sensor's noise
/// at the fragment's distance, and the error of the camera's calibration.
inline constexpr float kRangeSigmas = 3.0F;
/// The noise's part, times z².
inline float uncertainty_per_square(const DepthNoise& noise) {
  return kRangeSigmas * static_cast<float>(noise.sigma_steps) * inverse_step(noise);
}
inline float uncertainty_m(float source_z_m, float calibration_error_m, const DepthNoise& noise) {
  return uncertainty_per_square(noise) * (source_z_m * source_z_m) + calibration_error_m;
}

/// Weight of a sensor in the quality index: how many times smaller its noise is than a Kinect v1's.
inline float precision(const DepthNoise& noise) {
  return uncertainty_per_square(kKinectV1Noise) / uncertainty_per_square(noise);
}

/// The quality index of thesis eq. 2.5, 1/m^2; z_m > 0 along the source camera's axis. Eq. 2.5 compares equal
/// sensors; the factor precision() makes it comparable between different ones.
inline float quality_index(float cosine, float z_m, DepthState state, const DepthNoise& noise) {
  return precision(noise) * (cosine / (z_m * z_m)) * (state == DepthState::kFilled ? kFilledWorth : 1.0F);
}

/// A fragment's quality for the merge: full up to half the range behind the nearest fragment, none at its
/// end, so that nothing jumps when noise carries it over. `behind_m` >= 0, `range_m` > 0; the nearest has
/// behind_m = 0.
inline float fragment_worth(float quality, float behind_m, float range_m) {
  return quality * std::clamp(2.0F - 2.0F * behind_m / range_m, 0.0F, 1.0F);
}

/// Share of a fragment in the pixel's colour, before dividing by the sum of all shares: 1 for the best, 0 for
/// one worth less than kTieRatio of it, linear between. Depth, camera and quality of the pixel are the best
/// one's (the lowest camera index of equals).
inline constexpr float kTieRatio = 0.3F;
inline float blend_weight(float worth, float best_worth) {
  return std::clamp((worth - kTieRatio * best_worth) / ((1.0F - kTieRatio) * best_worth), 0.0F, 1.0F);
}

/// See Outlines above. In steps of the coarsest sensor in the view. For a Kinect, anything that stands 5 cm before a wall
/// 2.5 m away has an outline.
inline constexpr float kOutlineSteps = 8.0F;
inline constexpr int kOutlineDivisor = 4;

/// Gray, 0 to 1, of a surface of a camera without colour: lit from that camera.
inline constexpr float kAmbient = 0.15F;
inline float shade_without_color(float cosine) {
  return kAmbient + (1.0F - kAmbient) * cosine;
}

}  // namespace copresence::renderer
