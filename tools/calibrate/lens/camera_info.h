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
  friend bool operator==(const CameraInfo&, const CameraInfo&) = default;
};

/// Distortion as rational_polynomial: k1 k2 p1 p2 k3 k4 k5 k6. Numbers keep every bit.
std::string to_camera_info(const CameraInfo& camera);

/// Also takes plumb_bob with four or five numbers.
/// Fails  kCorrupt with `PATH:LINE: what`: no YAML, a key missing, sizes or numbers that cannot be.
Result<CameraInfo> parse_camera_info(const std::string& text, const std::filesystem::path& path);

/// Fails  kNotFound, and as parse_camera_info().
Result<CameraInfo> load_camera_info(const std::filesystem::path& path);

/// Fails  kUnavailable where it cannot be written.
Result<void> save_camera_info(const CameraInfo& camera, const std::filesystem::path& path);

}  // namespace copresence::calibrate
