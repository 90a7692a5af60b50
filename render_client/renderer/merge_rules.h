#pragma once

// The rules that both renderers follow, so that their pictures agree: which pixels are connected to
// a surface, how good a fragment is, and which fragments make the colour of a view's pixel.
//
// Most rules use the inverse depth w = 1/z (1/m, z along the camera's axis). The depth levels of a
// sensor are evenly spaced in w (DepthNoise), and w of a plane is an affine function of the pixel.
// So the tests below are linear.
//
// Surface      The pixels of a camera are the vertices of a grid, with pixel centres at whole
//              coordinates. A triangle of three neighbouring pixels is drawn if all three have
//              depth and connected() holds. The quad (x, y) to (x+1, y+1) is split from its top
//              right to its bottom left corner. If this diagonal does not give two triangles, the
//              other one is used if that gives two; else the single triangle is drawn. Only the
//              side that the camera saw is drawn. Planar regions may be drawn coarser if all their
//              pixels lie within kPlanarSteps of the plane. A quad of two triangles may be drawn as
//              the one plane nearest to its corners.
// Fragment     Depth and texture coordinate are interpolated with perspective. A fragment has the
//              state of the pixel nearest to its texture coordinate, and the cos(theta) of that
//              pixel's cell.
// Merge        See blend_weight() and blend_share() below.
// Colour       Bilinear in the camera's image, clamped at its border, then color_correction,
//              clamped to 0..1. A camera without colour shows the gray of shade_without_color().
// Stale        A camera whose opacity is below 1 is shown only where no live camera shows anything
//              at any distance. Stale cameras are merged among themselves like others. Their
//              colours are multiplied by the opacity.
// Silhouettes  A silhouette edge lies between two neighbours in a row whose nearest fragments are
//              kSilhouetteSteps apart in inverse depth along the eye's axis. Each takes a
//              kSilhouetteDivisor-th of its difference to the other's colour. This hides stair
//              steps: on average an edge covers half of its pixel.
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

/// Neighbours of one surface may differ by this many steps, because of noise and lossy coding.
inline constexpr float kGapSteps = 4.0F;
/// They may also differ by this slope of the surface, metres of depth per metre across: tan(80
/// degrees).
inline constexpr float kMaxSlope = 5.7F;

/// A region is planar if no pixel is farther than this from its plane.
inline constexpr float kPlanarSteps = 2.0F;

/// Limits for one camera's surface, in inverse depth (1/m).
struct SurfaceLimits {
  /// `pixel_angle` is the angle between neighbouring pixels in radians: 1 / fx. In a mesh that
  /// takes only every second pixel it is twice that.
  SurfaceLimits(const DepthNoise& noise, float pixel_angle)
      : gap(kGapSteps * inverse_step(noise)),
        slope(kMaxSlope * pixel_angle),
        planar(kPlanarSteps * inverse_step(noise)),
        curvature(inverse_step(noise)) {}

  float gap;    ///< greatest difference between neighbours through noise
  float slope;  ///< times w: greatest difference between neighbours through the slope of the surface
  /// Greatest distance of a pixel from the plane of its block of 4.
  float planar;
  /// Greatest distance of that plane from the plane of the next larger block. A plane fitted to 25
  /// pixels is accurate to a quarter of a step at its corners.
  float curvature;
};

/// Whether three neighbouring pixels lie on one surface. Inverse depths, 1/m, all > 0.
inline bool connected(float a, float b, float c, const SurfaceLimits& limits) {
  const float nearest = std::max({a, b, c});
  const float farthest = std::min({a, b, c});
  return nearest - farthest <= limits.gap + limits.slope * farthest;
}

/// Surface normals are estimated for cells of this many pixels a side, the first at (0, 0). Least
/// squares fits w over the pixels of a cell that have depth; the first pixels of its neighbours may
/// take part. The resulting cos(theta) is interpolated between the centres of the cells.
inline constexpr int kCell = 8;
/// A cell with fewer pixels than this has kUnknownIncidence.
inline constexpr int kCellPixels = 16;
inline constexpr float kUnknownIncidence = 0.25F;

/// cos(theta) in (0, 1], where theta is the angle between the surface normal and the ray to the
/// surface. (The thesis uses the camera's axis instead of the ray, figure 2.9. For a level camera
/// every floor would then have 0.) `w` > 0 is the inverse depth at the middle of the cell, 1/m.
/// `dw_dx` and `dw_dy` are its change per unit of the ray (x, y, 1) there: the change per pixel
/// times fx and fy.
inline float cos_theta(float w, float dw_dx, float dw_dy, float x, float y) {
  // The plane n.P = 1 has w = n.(x, y, 1). So n = (dw_dx, dw_dy, w - x dw_dx - y dw_dy), and n.ray
  // = w.
  const float n_z = w - x * dw_dx - y * dw_dy;
  const float normal = std::sqrt(dw_dx * dw_dx + dw_dy * dw_dy + n_z * n_z);
  const float ray = std::sqrt(x * x + y * y + 1.0F);
  return std::min(1.0F, w / (normal * ray));
}

/// Weight of a filled pixel relative to a measured one.
inline constexpr float kFilledWeight = 0.25F;

/// A fragment may lie this far behind the nearest one and still belong to the same surface (thesis
/// 2.6.1): the sum of uncertainty_m() of both fragments, in metres along the eye's axis.
/// uncertainty_m() is kRangeSigmas of the sensor's noise at the fragment's distance, plus the
/// calibration error of the camera.
inline constexpr float kRangeSigmas = 3.0F;
/// The part of the noise, divided by z².
inline float uncertainty_per_square(const DepthNoise& noise) {
  return kRangeSigmas * static_cast<float>(noise.sigma_steps) * inverse_step(noise);
}
inline float uncertainty_m(float camera_z_m, float calibration_error_m, const DepthNoise& noise) {
  return uncertainty_per_square(noise) * (camera_z_m * camera_z_m) + calibration_error_m;
}

/// Factor of a sensor in the quality index: how many times smaller its noise is than that of a
/// Kinect v1.
inline float precision(const DepthNoise& noise) {
  return uncertainty_per_square(kKinectV1Noise) / uncertainty_per_square(noise);
}

/// The quality index of thesis eq. 2.5, 1/m^2; z_m > 0 along the camera's axis. Eq. 2.5 compares
/// equal sensors. The factor precision() makes different sensors comparable.
inline float quality_index(float incidence, float z_m, DepthState state, const DepthNoise& noise) {
  return precision(noise) * (incidence / (z_m * z_m)) * (state == DepthState::kFilled ? kFilledWeight : 1.0F);
}

/// Weight of a fragment in the merge: its whole quality up to half the range behind the nearest
/// fragment, falling to 0 at the end of the range. So nothing jumps when noise moves a fragment
/// over a limit. `behind_m` >= 0, 0 for the nearest fragment; `range_m` > 0.
inline float blend_weight(float quality, float behind_m, float range_m) {
  return quality * std::clamp(2.0F - 2.0F * behind_m / range_m, 0.0F, 1.0F);
}

/// Share of a fragment in the pixel's colour, before division by the sum of all shares: 1 for the
/// best fragment, 0 for weights below kTieRatio of the best, linear between. Depth, camera and
/// quality of the pixel are those of the best fragment. Of equal fragments the one with the lowest
/// camera index is the best.
inline constexpr float kTieRatio = 0.3F;
inline float blend_share(float weight, float best_weight) {
  return std::clamp((weight - kTieRatio * best_weight) / ((1.0F - kTieRatio) * best_weight), 0.0F, 1.0F);
}

/// See Silhouettes above. In steps of the coarsest sensor in the view. For a Kinect, an object 5 cm
/// in front of a wall at 2.5 m has a silhouette edge.
inline constexpr float kSilhouetteSteps = 8.0F;
inline constexpr int kSilhouetteDivisor = 4;

/// Gray, 0 to 1, of a surface of a camera without colour. The light comes from the camera.
inline constexpr float kAmbient = 0.15F;
inline float shade_without_color(float incidence) {
  return kAmbient + (1.0F - kAmbient) * incidence;
}

}  // namespace copresence::renderer
