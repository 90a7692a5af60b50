#pragma once

// Reads and writes intrinsics as ROS does: the YAML of sensor_msgs/CameraInfo, in the form of
// camera_calibration and camera_info_manager. Thread: pure functions.

#include <filesystem>
#include <string>
#include <string_view>

#include "common/frame/camera_model.h"
#include "common/result.h"

namespace copresence::calibrate {

struct CameraInfo {
  std::string name;
  CameraModel model;
  std::string remark = {};  ///< Message for the user; may be empty.
  friend bool operator==(const CameraInfo&, const CameraInfo&) = default;
};

/// Writes distortion as rational_polynomial: k1 k2 p1 p2 k3 k4 k5 k6. Numbers keep full precision.
std::string to_camera_info(const CameraInfo& camera);

/// Reads files of camera_calibration and camera_info_manager, messages as `rostopic echo` and `ros2
/// topic echo` print them, and OpenCV's YAML with the same keys. The distortion model is plumb_bob
/// or rational_polynomial, under any of their usual names, or unnamed. The model may have up to 14
/// coefficients; those after the eighth must be 0. The camera's name may contain any bytes.
/// Fails with kCorrupt and `PATH:LINE: message` for invalid YAML, a missing key or impossible
/// numbers. Also fails so for other distortion models, such as fisheye, and for binned or cropped
/// pictures.
Result<CameraInfo> parse_camera_info(const std::string& text, const std::filesystem::path& path);

/// Fails with kNotFound if there is no such file, with kCorrupt if it exceeds 1 MiB, and as
/// parse_camera_info() does.
Result<CameraInfo> load_camera_info(const std::filesystem::path& path);

/// Fails with kUnavailable if the file cannot be written.
Result<void> save_camera_info(const CameraInfo& camera, const std::filesystem::path& path);

}  // namespace copresence::calibrate
