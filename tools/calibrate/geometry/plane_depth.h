#pragma once

// Depth at a marker: not that of one pixel, but of the plane that fits the marker's whole neighbourhood over many frames.
// Of a plane, 1/z is linear over the picture, and a Kinect's noise is the same everywhere in 1/z; so the fit is a line
// of least squares there, on what a random search found to belong to one plane.
//
// Thread: one thread per object; the functions are pure.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibration {

/// Depth of every pixel over a number of frames of a still scene. Sums of 1/z; values far from a pixel's first ones
/// (somebody walked by, an edge that flickers) are left out.
class DepthAverage {
 public:
  explicit DepthAverage(DepthUnit unit) : unit_(unit) {}

  /// Requires every image to be of the first one's size.
  void add(const DepthImage& depth);

  int frames() const { return frames_; }
  int width() const { return inverse_sum_.width(); }
  int height() const { return inverse_sum_.height(); }

  /// Mean of 1/z, 1/m; 0 where fewer than a quarter of the frames have depth.
  double inverse_depth(int x, int y) const;

 private:
  DepthUnit unit_;
  int frames_ = 0;
  Image<float> inverse_sum_;
  Image<std::uint16_t> count_;
};

/// 1/z = slope . ray + offset, in 1/m, for rays (x, y, 1) of the camera.
struct PlaneFit {
  Eigen::Vector2d slope{0, 0};
  double offset = 0;
  int pixels = 0;        ///< that agree
  double share = 0;      ///< of the neighbourhood's pixels with depth, 0 to 1
  double rms_steps = 0;  ///< of those that agree, in sensor steps

  /// Depth of the plane along a ray, metres. Requires that the plane lies in front of the camera there.
  double z_along(const Eigen::Vector2d& ray) const { return 1 / (slope.dot(ray) + offset); }
};

/// The plane through what a convex outline (pixels, in order) holds.
///
/// Fails   kNotFound: fewer than `kFewestPixels` of its pixels have depth, or fewer than half of those agree on a plane.
inline constexpr int kFewestPixels = 30;
Result<PlaneFit> fit_plane(const DepthAverage& depth, const CameraModel& model,
                           std::span<const Eigen::Vector2d> outline);

}  // namespace copresence::calibration
