#pragma once

// The pinhole camera with OpenCV's rational distortion (thesis eq. 2.1 to 2.4). Pixel centres lie
// at whole coordinates: (0, 0) is the middle of the top left pixel.
//
// If only the field of view is known, the principal point is (width / 2, height / 2). Sensors,
// simulated cameras and views all follow this rule. Therefore a view from the pose of a nominal
// camera shows that camera's picture, pixel by pixel, if size and field of view are equal. The rule
// is OpenNI's: convertDepthToWorld() takes column / width - 0.5, so column width / 2 is on the
// optical axis. The middle of the picture, at (width - 1) / 2, would shift the scene 3 mm sideways
// at 3 m. Calibrated principal points of real Kinects lie up to ten pixels from either point.
// Thread: free functions on values, safe anywhere.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/result.h"

namespace copresence {

struct CameraModel {
  int width = 0;  ///< Pixels; even.
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< Pixels.
  std::array<double, 8> distortion{};     ///< OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6.

  bool is_distorted() const;
  friend bool operator==(const CameraModel&, const CameraModel&) = default;
};

/// A camera without distortion, with its principal point at (width / 2, height / 2). Angles are in
/// radians.
CameraModel camera_from_field_of_view(int width, int height, double horizontal, double vertical);

/// The same camera with square pixels. Requires `vertical` in (0, pi) radians.
CameraModel camera_from_field_of_view(int width, int height, double vertical);

/// Camera model of an uncalibrated Kinect v1, with square pixels and the nominal field of view of
/// 58.1 degrees along the longer side. At 640x480, fx = fy = 575.8.
CameraModel nominal_kinect(int width, int height);

/// Camera model of a sensor or recording that reports its field of view, in radians. Many devices
/// report the angles of their 4:3 mode in every mode. If the angles give pixels more than 5 % out
/// of square, only the longer side's angle is used.
CameraModel camera_of_sensor(int width, int height, double horizontal, double vertical);

/// Validates a camera model from untrusted input. Fails with kInvalid unless sizes are even and
/// from 2 to 4096, all numbers are finite, focal lengths are positive, and the distortion is
/// one-to-one in the whole picture.
Result<void> check(const CameraModel& camera);

/// Returns the pixel at which a point of the camera frame (metres, z > 0) appears. The pixel may
/// lie outside the image.
Eigen::Vector2d project(const CameraModel& camera, const Eigen::Vector3d& point_in_camera);

/// Returns the point of the camera frame that appears at `pixel` and has depth `z_m` along the
/// optical axis. The pixel error is below 1e-6 px in the whole picture if check() accepts the
/// model.
Eigen::Vector3d unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, double z_m);

/// Returns (x, y) at z = 1 for every pixel, row by row: width * height entries. A pixel's 3-D point
/// is (x, y, 1) times its depth.
std::vector<Eigen::Vector2f> rays(const CameraModel& camera);

}  // namespace copresence
