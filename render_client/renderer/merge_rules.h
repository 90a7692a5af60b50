#pragma once

// Rules that both renderers follow, so that their pictures agree. They define which pixels form a
// surface, how good a fragment is, and which fragments make the colour of a pixel of the view.
//
// Most rules use the inverse depth w = 1/z (1/m, z along the camera's axis). The depth levels of a
// sensor are evenly spaced in w (DepthNoise), and w of a plane is an affine function of the pixel.
// So the tests below are linear.
//
// Surface      The pixels of a camera are the vertices of a grid, with pixel centres at integer
//              coordinates. A triangle of three neighbouring pixels is drawn if all three have
//              depth and connected() holds. The quad (x, y) to (x+1, y+1) is split from its top
//              right to its bottom left corner. If this does not give two triangles but the other
//              diagonal does, the quad is split along the other diagonal. If neither diagonal gives
//              two triangles, the single possible triangle is drawn. Back faces are not drawn. A
//              region may be drawn with larger triangles if all its pixels lie within kPlanarSteps
//              of a plane. A quad of two triangles may be drawn as the plane nearest to its
//              corners.
// Fragment     Depth and texture coordinate are interpolated with perspective. A fragment has the
//              state of the pixel nearest to its texture coordinate, and the cos(theta) of that
//              pixel's cell. Its weight falls towards the picture's border, see border_fade().
// Merge        See MergeMode, blend_weight() and blend_share() below.
// Colour       The camera's image is sampled bilinearly and clamped at its border. Then the colour
//              correction is applied and the result clamped to 0..1. A camera without colour shows
//              the gray of shade_without_color(), from the normals of shading.h.
// Stale        A camera with an opacity below 1 is stale. It is shown only where no live camera
//              shows anything at any distance. Stale cameras are merged with each other like live
//              ones. Their colours are multiplied by the opacity.
// Remembered   A remembered background is shown only where no camera's newest frame shows anything
//              at any distance. So it never covers what is seen. Remembered backgrounds are merged
//              with each other like live cameras.
// Left out     A pixel without depth whose state is not kHole shows a surface that is not drawn,
//              because another camera shows it (render_client/moving_surfaces). Extended surfaces
//              take no colour from such a pixel (extension_rules.h).
// Silhouettes  A silhouette edge lies between two neighbours in a row or a column. The inverse
//              depths of their nearest fragments, along the eye's axis, differ by more than
//              kSilhouetteSteps. Each colour moves 1 / kSilhouetteDivisor of the way to the other
//              colour, first along all rows, then along all columns. This hides stair steps.
//              Columns are left out if unseen pixels stay black (UnseenStyle).
//
// Thread: pure functions.

#include <algorithm>
#include <cmath>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"

namespace copresence::renderer {

/// A fragment is shown only where no fragment of a lower rank is: see Stale and Remembered above.
enum class Rank { kLive, kStale, kRemembered };
inline Rank rank(float opacity, bool is_remembered) {
  if (is_remembered) return Rank::kRemembered;
  return opacity < 1 ? Rank::kStale : Rank::kLive;
}

/// One step of the sensor in inverse depth, 1/m.
inline float inverse_step(const DepthNoise& noise) {
  return 1.0F / static_cast<float>(noise.disparity_constant_m);
}

/// Neighbours on one surface may differ by this many steps, because of noise and lossy coding.
inline constexpr float kGapSteps = 4.0F;
/// A surface may also slope by this many metres of depth per metre across: tan(80 degrees).
inline constexpr float kMaxSlope = 5.7F;

/// A region is planar if no pixel is farther than this from its plane.
inline constexpr float kPlanarSteps = 2.0F;

/// Limits for one camera's surface, in inverse depth (1/m).
struct SurfaceLimits {
  /// `pixel_angle` is the angle between neighbouring vertices in radians. It is 1 / fx, or 2 / fx
  /// in a mesh of every second pixel.
  SurfaceLimits(const DepthNoise& noise, float pixel_angle)
      : gap(kGapSteps * inverse_step(noise)),
        slope(kMaxSlope * pixel_angle),
        planar(kPlanarSteps * inverse_step(noise)),
        curvature(inverse_step(noise)) {}

  float gap;     ///< Greatest difference between neighbours that noise explains.
  float slope;   ///< Greatest difference that the slope explains, divided by w.
  float planar;  ///< Greatest distance of a pixel from the plane of its 4x4 block.
  /// Greatest distance between the planes of a 4x4 block and of the next larger block. A plane
  /// that is fitted to 25 pixels is accurate to a quarter of a step at its corners.
  float curvature;
};

/// Returns whether three neighbouring pixels with inverse depths a, b, c > 0 lie on one surface.
inline bool connected(float a, float b, float c, const SurfaceLimits& limits) {
  const float nearest = std::max({a, b, c});
  const float farthest = std::min({a, b, c});
  return nearest - farthest <= limits.gap + limits.slope * farthest;
}

/// Surface normals are estimated for cells of this many pixels a side, the first at (0, 0). A plane
/// of w is fitted to the pixels of a cell that have depth, by least squares. A renderer may include
/// the adjoining pixels of the next cells. cos(theta) is interpolated between the cells' centres.
inline constexpr int kCell = 8;
/// A cell with fewer pixels than this has kUnknownIncidence.
inline constexpr int kCellPixels = 16;
inline constexpr float kUnknownIncidence = 0.25F;

/// Returns cos(theta) in (0, 1], where theta is the angle between the surface normal and the ray
/// (x, y, 1) to the surface. The thesis uses the camera's axis in place of the ray (figure 2.9),
/// which would give 0 for every floor if the camera is level. `w` > 0 is the inverse depth at the
/// middle of the cell, 1/m. `dw_dx` and `dw_dy` are its derivatives by x and y.
inline float cos_theta(float w, float dw_dx, float dw_dy, float x, float y) {
  // On the plane n.P = 1, w = n.(x, y, 1). So n = (dw_dx, dw_dy, w - x dw_dx - y dw_dy).
  const float n_z = w - x * dw_dx - y * dw_dy;
  const float normal = std::sqrt(dw_dx * dw_dx + dw_dy * dw_dy + n_z * n_z);
  const float ray = std::sqrt(x * x + y * y + 1.0F);
  return std::min(1.0F, w / (normal * ray));
}

/// Weight of a filled pixel relative to a measured one.
inline constexpr float kFilledWeight = 0.25F;

/// A factor of a fragment's weight, which reduces the weight near the picture's border. The factor
/// rises from 0 at the border to 1 at a distance of kBorderShare times the picture's width.
/// Otherwise different exposures of two cameras would show as a line. `distance` is the distance
/// from the nearest border, in pixels.
inline constexpr float kBorderShare = 0.05F;
inline float border_fade(int distance, int width) {
  return std::min(1.0F, (static_cast<float>(distance) + 0.5F) / (kBorderShare * static_cast<float>(width)));
}

/// The uncertainty range (thesis 2.6.1): a fragment may lie this far behind the nearest one and
/// still belong to the same surface. It is the sum of uncertainty_m() of both fragments, in metres
/// along the eye's axis. One uncertainty_m() is kRangeSigmas standard deviations of the sensor's
/// noise at the fragment's distance, plus the camera's calibration error.
inline constexpr float kRangeSigmas = 3.0F;
/// The sensor's part of uncertainty_m(), divided by the square of the depth, in 1/m.
inline float uncertainty_per_square(const DepthNoise& noise) {
  return kRangeSigmas * static_cast<float>(noise.sigma_steps) * inverse_step(noise);
}
inline float uncertainty_m(float camera_z_m, float calibration_error_m, const DepthNoise& noise) {
  return uncertainty_per_square(noise) * (camera_z_m * camera_z_m) + calibration_error_m;
}

/// Precision of a sensor relative to a Kinect v1: 2 means half of its noise.
inline float precision(const DepthNoise& noise) {
  return uncertainty_per_square(kKinectV1Noise) / uncertainty_per_square(noise);
}

/// Returns the quality index of a fragment (thesis eq. 2.5), 1/m^2. `z_m` > 0 is its depth along
/// the camera's axis. The factor precision() is added to make different sensors comparable.
inline float quality_index(float incidence, float z_m, DepthState state, const DepthNoise& noise) {
  return precision(noise) * (incidence / (z_m * z_m)) * (state == DepthState::kFilled ? kFilledWeight : 1.0F);
}

/// Returns the weight of a fragment in the merge. `behind_m` >= 0 is its distance behind the
/// nearest fragment, `range_m` > 0 the uncertainty range. Up to half of the range, the weight
/// equals the quality. Then it falls linearly to 0, so that noise causes no sudden changes.
inline float blend_weight(float quality, float behind_m, float range_m) {
  return quality * std::clamp(2.0F - 2.0F * behind_m / range_m, 0.0F, 1.0F);
}

/// Selects the fragments that make the colour of a pixel.
enum class MergeMode {
  kBlend,    ///< The best fragment, blended with others of similar weight.
  kBest,     ///< The best fragment alone (thesis 2.6.1).
  kNearest,  ///< The nearest fragment alone, as an ordinary depth test would show.
};

/// Fragments with less than this ratio of the best weight are not shown.
inline constexpr float kTieRatio = 0.3F;        ///< For MergeMode::kBlend.
inline constexpr float kBestTieRatio = 0.999F;  ///< For MergeMode::kBest.
inline float tie_ratio(MergeMode mode) {
  return mode == MergeMode::kBlend ? kTieRatio : kBestTieRatio;
}

/// Returns the share of a fragment in the pixel's colour, before division by the sum of all shares.
/// It rises linearly from 0 at `tie_ratio` times the best weight to 1 at the best weight. Depth,
/// camera and quality of the pixel are those of the best fragment. Of equal fragments, the one with
/// the lowest camera index is the best.
inline float blend_share(float weight, float best_weight, float tie_ratio = kTieRatio) {
  return std::clamp((weight - tie_ratio * best_weight) / ((1.0F - tie_ratio) * best_weight), 0.0F, 1.0F);
}

/// Minimum depth difference at a silhouette edge, in disparity steps of the coarsest sensor in the
/// view. For a Kinect, an object 5 cm in front of a wall at 2.5 m has a silhouette edge.
inline constexpr float kSilhouetteSteps = 8.0F;
inline constexpr int kSilhouetteDivisor = 4;

/// Gray value, 0 to 1, of a surface when the camera has no colour. The light comes from the camera.
inline constexpr float kAmbient = 0.15F;
inline float shade_without_color(float incidence) {
  return kAmbient + (1.0F - kAmbient) * incidence;
}

}  // namespace copresence::renderer
