#pragma once

// The pin-hole camera with OpenCV's rational distortion (thesis eq. 2.1 to 2.4).
// Pixel centres lie at whole coordinates: (0, 0) is the middle of the top left pixel.
//
// Principal point where only the field of view is known: column width / 2 and row height / 2, for sensors, simulated
// cameras and views alike. This is OpenNI's definition of the field of view: convertDepthToWorld() takes
// column / width - 0.5, so column width / 2 is on the optical axis, column 0 at minus half the field of view, and column
// width at plus half of it. Half a pixel beside it, (width - 1) / 2, would be the middle of the picture; it would move
// every point 3 mm sideways at 3 m. Real Kinects do not decide between the two: their calibrated principal points lie
// up to ten pixels from both. One rule everywhere means that a view from the pose of a nominal camera, with its size and
// field of view, shows that camera's own picture, pixel by pixel.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/result.h"

namespace copresence {

struct CameraModel {
  int width = 0;  ///< pixels; even
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::array<double, 8> distortion{};     ///< k1 k2 p1 p2 k3 k4 k5 k6, OpenCV's order

  bool is_distorted() const;
  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

/// A camera without distortion; its principal point is (width / 2, height / 2), see above. Radians.
CameraModel camera_from_field_of_view(int width, int height, double horizontal, double vertical);

/// The same with square pixels. `vertical` in (0, pi), radians.
CameraModel camera_from_field_of_view(int width, int height, double vertical);

/// What a camera model from outside must satisfy: even sizes from 2 to 4096, finite numbers, positive focal
/// lengths, and a distortion that sends different rays to different pixels all over the picture.
Result<void> check(const CameraModel& camera);

/// Pixel at which a point of the camera frame (metres, z > 0) appears; may lie outside the image.
Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_camera);

/// Point of the camera frame at depth `z_m` along the optical axis that appears at `pixel`.
/// The distortion is inverted by Newton's method, to below 1e-6 px anywhere in the picture of a model that check()
/// accepts.
Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, double z_m);

/// (x, y) at z = 1 for every pixel, row by row: what a renderer multiplies with depth. width * height
/// entries.
std::vector<Eigen::Vector2f> rays(const CameraModel& camera);

}  // namespace copresence
