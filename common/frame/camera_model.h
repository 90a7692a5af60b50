#pragma once

// The pin-hole camera with OpenCV's rational distortion (thesis eq. 2.1 to 2.4).
// Pixel centres lie at whole coordinates: (0, 0) is the middle of the top left pixel.
//
// If only the field of view is known, the principal point is column width / 2, row height / 2.
// Sensors, simulated cameras and views all follow this rule, which is OpenNI's definition of the
// field of view: convertDepthToWorld() takes column / width - 0.5. So column width / 2 is on the
// optical axis, column 0 at minus half the field of view, and column width at plus half of it. The
// middle of the picture is half a pixel beside it, at (width - 1) / 2. That point would shift the
// scene 3 mm sideways at 3 m. The calibrated principal points of real Kinects are up to ten pixels
// from both. With one rule, a view from the pose of a nominal camera shows that camera's own
// picture, pixel by pixel, if size and field of view are the same.
//
// Thread: free functions on values, safe anywhere.

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

/// A camera without distortion, with its principal point at (width / 2, height / 2). Radians.
CameraModel camera_from_field_of_view(int width, int height, double horizontal, double vertical);

/// The same with square pixels. `vertical` in (0, pi), radians.
CameraModel camera_from_field_of_view(int width, int height, double vertical);

/// Camera model of a Kinect v1 that is not calibrated: square pixels, and the nominal field of view
/// of 58.1 degrees along the longer side. At 640x480 that is fx = fy = 575.8.
CameraModel nominal_kinect(int width, int height);

/// Camera model of a sensor or recording that reports its field of view, in radians. Many devices
/// report the angles of their 4:3 mode in every mode. If the two angles make pixels more than 5 %
/// out of square, only the longer side's angle is used.
CameraModel camera_of_sensor(int width, int height, double horizontal, double vertical);

/// Validates a camera model from untrusted input. Sizes must be even, from 2 to 4096, numbers
/// finite, focal lengths positive, and the distortion one-to-one everywhere in the picture. Fails
/// with kInvalid.
Result<void> check(const CameraModel& camera);

/// Pixel at which a point of the camera frame (metres, z > 0) appears. It may lie outside the
/// image.
Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_camera);

/// Point of the camera frame at depth `z_m` along the optical axis that appears at `pixel`.
/// Newton's method inverts the distortion to below 1e-6 px anywhere in the picture, if check()
/// accepts the model.
Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, double z_m);

/// (x, y) at z = 1 for every pixel, row by row: width * height entries. Multiplied by depth they
/// give a renderer's points.
std::vector<Eigen::Vector2f> rays(const CameraModel& camera);

}  // namespace copresence
