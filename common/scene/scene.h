#pragma once

// Reads the scene file (TOML): the cameras of a set-up, their poses and their calibration. The
// servers, the client and `calibrate` use this file. See docs/guide/scene_file.md for the keys.
// Thread: pure functions and values.

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"

namespace copresence::scene {

/// The colour camera of a sensor whose driver does not register depth to colour.
struct ColorCamera {
  CameraModel model;
  Rigid3 color_from_depth;  ///< Translation in metres.
};

struct Camera {
  std::string name;
  std::string address;                      ///< HOST:PORT of its capture_server, or empty.
  CameraModel model;                        ///< Model of the depth camera.
  std::optional<Rigid3> world_from_camera;  ///< Translation in metres.
  /// The source that its capture_server opens. A path in the file is relative to the file's folder.
  std::string source;
  std::optional<ColorCamera> color;
  /// Colour correction of RGB values from 0 to 1, to the reference camera.
  std::optional<Eigen::Matrix<float, 3, 4>> color_matching;
  std::optional<double> calibration_error_mm;
};

struct Box {
  Eigen::Vector3d min, max;  ///< In the world frame, in metres.
};

struct Scene {
  Eigen::Vector3d up{0, -1, 0};  ///< Up direction of the world, a unit vector.
  /// Path of the key file that the room's servers and clients share, or empty. A relative path in
  /// the file is relative to the file's folder.
  std::string key;
  std::vector<Camera> cameras;
  std::optional<Box> clip;  ///< The part of the world to show.

  const Camera* find(std::string_view name) const;  ///< Returns nullptr if no camera has this name.
};

/// Reads a scene file. Fails with `PATH:LINE: reason` for bad TOML, unknown keys, missing or
/// impossible values, and repeated camera names.
Result<Scene> load(const std::filesystem::path& path);

/// Like load(), but for a text. `path` is used for error messages and as base of relative paths.
Result<Scene> parse(std::string_view text, const std::filesystem::path& path);

}  // namespace copresence::scene
