#pragma once

// A camera's lens as ROS writes it: the YAML of sensor_msgs/CameraInfo, as camera_calibration and camera_info_manager
// read and write it. The only yaml-cpp. Thread: pure functions.

#include <filesystem>
#include <string>
#include <string_view>

#include "common/frame/camera_model.h"
#include "common/result.h"

namespace copresence::calibrate {

struct CameraInfo {
  std::string name;
  CameraModel model;
  std::string remark = {};  ///< what a person should know of it; empty where there is nothing
  friend bool operator==(const CameraInfo&, const CameraInfo&) = default;
};

/// Writes distortion as rational_polynomial: k1 k2 p1 p2 k3 k4 k5 k6. Numbers keep every bit.
std::string to_camera_info(const CameraInfo& camera);

/// Reads what ROS and its users write: files of camera_calibration and camera_info_manager, a message as `rostopic echo`
/// and `ros2 topic echo` print it, and OpenCV's YAML with the same keys. Distortion is plumb_bob or rational_polynomial,
/// by whichever of their names or none, of up to 14 coefficients, those beyond the eighth being 0. The name may be any bytes.
/// Fails  kCorrupt with `PATH:LINE: what`: no YAML, a key missing, sizes or numbers that cannot be; a fisheye lens or another
///        distortion model, which it names; pictures that are a part of the sensor's.
Result<CameraInfo> parse_camera_info(const std::string& text, const std::filesystem::path& path);

/// Fails  kNotFound; kCorrupt for a file of more than 1 MiB, and as parse_camera_info().
Result<CameraInfo> load_camera_info(const std::filesystem::path& path);

/// Fails  kUnavailable where it cannot be written.
Result<void> save_camera_info(const CameraInfo& camera, const std::filesystem::path& path);

}  // namespace copresence::calibrate
