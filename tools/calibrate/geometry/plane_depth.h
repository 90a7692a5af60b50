#pragma once

// Computes the mean depth of a still scene, and finds planes in it. Both calculations use 1/z,
// because a Kinect's noise has the same standard deviation everywhere in 1/z, and 1/z of a plane is
// linear over the picture. So a mean of 1/z and a linear least-squares fit to 1/z are the best
// estimates. Thread: one thread per object; the functions are pure.

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::calibrate {

/// Mean depth of every pixel over the frames of a still scene. Keeps running sums, so its size does
/// not depend on the number of frames.
///
/// Each pixel averages one surface. Values farther than kSameSurface_steps from the mean belong to
/// another surface, such as a passing person or a flickering edge. Once such values are as many as
/// the averaged ones, the mean starts again with the latest value.
class DepthAverage {
 public:
  static constexpr double kSameSurface_steps = 3;
  static constexpr int kMostFrames = 65535;

  explicit DepthAverage(DepthUnit unit) : unit_(unit) {}

  /// All images must have the same size. At most kMostFrames may be added.
  void add(const DepthImage& depth);

  int frames() const { return frames_; }
  int width() const { return inverse_sum_.width(); }
  int height() const { return inverse_sum_.height(); }

  /// Mean of 1/z, in 1/m; 0 if it averages fewer than a quarter of the frames.
  double inverse_depth(int x, int y) const;

  /// Depth of the still pixels, metres along the optical axis; 0 for the others. A pixel is still
  /// if at least half of the frames measured it and four fifths of these values belong to its mean.
  Image<float> still_depth() const;

  /// Share of pixels with depth, averaged over the frames.
  double measured_share() const;

  /// Of the pixels that at least half of the frames measured, the share that is not still. Such
  /// pixels lie on moving objects, and at edges where the sensor flickers.
  double unsteady_share() const;

 private:
  struct Counts {
    std::uint16_t measured = 0;  ///< Number of frames with depth.
    std::uint16_t agreeing = 0;  ///< Number of values in the sum.
    /// Number of values on other surfaces since the first value of the mean.
    std::uint16_t against = 0;
  };
  bool is_measured(const Counts& counts) const {
    return counts.measured > 0 && 2 * counts.measured >= frames_;
  }
  static bool is_still(const Counts& counts) { return 5 * counts.agreeing >= 4 * counts.measured; }

  DepthUnit unit_;
  int frames_ = 0;
  Image<float> inverse_sum_;
  Image<Counts> counts_;
};

/// Least-squares fit of value = x_slope x + y_slope y + offset to added samples.
template <class Scalar>
class PlaneLeastSquares {
 public:
  using Coefficients = Eigen::Matrix<Scalar, 3, 1>;  ///< X slope, y slope, offset.

  void add(Scalar x, Scalar y, Scalar value) {
    n_ += 1;
    x_ += x;
    y_ += y;
    xx_ += x * x;
    xy_ += x * y;
    yy_ += y * y;
    v_ += value;
    vx_ += value * x;
    vy_ += value * y;
  }

  Scalar count() const { return n_; }

  /// Returns false if the samples lie on a line: if the determinant of the normal equations is
  /// below `least` per sample.
  bool solve(Scalar least, Coefficients& plane) const {
    Eigen::Matrix<Scalar, 3, 3> normal;
    normal << xx_, xy_, x_, xy_, yy_, y_, x_, y_, n_;
    if (!(std::abs(normal.determinant()) > least * n_)) return false;
    plane = normal.inverse() * Coefficients(vx_, vy_, v_);
    return true;
  }

 private:
  Scalar n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0, yy_ = 0, v_ = 0, vx_ = 0, vy_ = 0;
};

/// A plane: 1/z = slope * (x, y) + offset, in 1/m, along the camera's ray (x, y, 1).
struct PlaneFit {
  Eigen::Vector2d slope{0, 0};
  double offset = 0;
  int pixels = 0;        ///< Number of pixels on the plane.
  double share = 0;      ///< Share of the outline's measured pixels that are on the plane, 0 to 1.
  double rms_steps = 0;  ///< RMS distance of those pixels from the plane, in disparity steps.

  /// Depth of the plane along a ray, metres. The plane must lie in front of the camera along that
  /// ray.
  double z_along(const Eigen::Vector2d& ray) const { return 1 / (slope.dot(ray) + offset); }
};

/// Fits a plane to the depth inside a convex outline (corner pixels in order). RANSAC finds the
/// plane that most pixels lie on. Least squares over those pixels refines it.
///
/// Fails with kNotFound if fewer than `kFewestPixels` of the pixels have depth, or if fewer than
/// half of those lie on one plane.
inline constexpr int kFewestPixels = 30;
Result<PlaneFit> fit_plane(const DepthAverage& depth, const CameraModel& model,
                           std::span<const Eigen::Vector2d> outline);

}  // namespace copresence::calibrate
