#pragma once

// Writes the images of one camera to a folder, with their times, poses and the camera's data.
//
// TUM's format (Sturm et al. 2012) has depth/TIME.png, rgb/TIME.jpg, and the lists depth.txt, rgb.txt
// and groundtruth.txt. The 7-Scenes format (Shotton et al. 2013) has frame-NNNNNN.depth.png,
// frame-NNNNNN.color.jpg and frame-NNNNNN.pose.txt. Both have our camera.json. Thread: one thread.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>

#include "capture_server/recording/camera_metadata.h"
#include "common/frame/image.h"
#include "common/result.h"
#include "tools/record/settings.h"

namespace copresence::record {

class ExportFolder {
 public:
  /// Makes the folder. Fails with kInvalid if it exists and is not empty, and with kUnavailable if
  /// it cannot be made.
  static Result<ExportFolder> create(const std::filesystem::path& path, ExportFormat format,
                                     recording::CameraMetadata camera);

  /// Writes a depth image. In 7-Scenes format, the colour images up to the next call belong to it.
  Result<void> add_depth(std::chrono::microseconds time, const DepthImage& image,
                         const std::optional<Rigid3>& world_from_camera);
  /// Writes a colour image as PNG, or the bytes of a JPEG file unchanged.
  Result<void> add_color(std::chrono::microseconds time, const ColorImage& image);
  Result<void> add_color(std::chrono::microseconds time, std::span<const std::uint8_t> jpeg);

  /// Writes the camera's data. Call it last. Fails if a list could not be written.
  Result<void> finish();

  const std::filesystem::path& path() const { return path_; }
  std::size_t depth_images() const { return depth_images_; }
  std::size_t color_images() const { return color_images_; }

 private:
  ExportFolder(std::filesystem::path path, ExportFormat format, recording::CameraMetadata camera);

  double depth_per_metre() const;
  /// Returns the name of a colour image in the folder, and adds it to the list.
  std::string note_color(std::chrono::microseconds time, const char* extension);
  Result<void> write_pose(std::chrono::microseconds time, const Rigid3& world_from_camera);

  std::filesystem::path path_;
  ExportFormat format_;
  recording::CameraMetadata camera_;
  std::ofstream depth_list_, color_list_, poses_;
  std::size_t depth_images_ = 0, color_images_ = 0;
};

/// The data in camera.json: the note of a recording, and the pixel value of one metre.
struct ExportedCamera {
  recording::CameraMetadata camera;
  double depth_per_metre = 0;
};
inline constexpr const char* kCameraFile = "camera.json";

/// Reads camera.json of a folder. Returns nothing if there is none. Fails with kCorrupt.
Result<std::optional<ExportedCamera>> read_exported_camera(const std::filesystem::path& folder);

}  // namespace copresence::record
