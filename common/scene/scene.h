#pragma once

// The scene file (TOML): which cameras there are, where they stand and what is known of them. Read by the
// servers, the client and `calibrate`. The keys are documented in docs/guide/scene_file.md.
//
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

/// The colour camera of a sensor whose driver does not register.
struct ColorCamera {
  CameraModel model;
  Rigid3 color_from_depth;  ///< metres
};

struct Camera {
  std::string name;
  std::string address;                      ///< HOST:PORT of its capture_server; empty where not said
  CameraModel model;                        ///< of the depth camera
  std::optional<Rigid3> world_from_camera;  ///< metres
  std::string
      source;  ///< what its capture_server opens; a relative recording's path is made relative to the file
  std::optional<ColorCamera> color;
  std::optional<Eigen::Matrix<float, 3, 4>> color_matching;  ///< RGB 0 to 1, to the reference camera
  std::optional<double> calibration_error_mm;
};

struct Box {
  Eigen::Vector3d min, max;  ///< world, metres
};

struct Scene {
  Eigen::Vector3d up{0, -1, 0};  ///< the world's up, a unit vector
  std::vector<Camera> cameras;
  std::optional<Box> clip;  ///< what to show

  const Camera* find(std::string_view name) const;  ///< nullptr where there is none
};

/// Fails with `PATH:LINE: what is wrong` on bad TOML, unknown keys, missing or impossible values, names used
/// twice.
Result<Scene> load(const std::filesystem::path& path);

/// The same on a text; `path` is what errors name and what relative paths are relative to.
Result<Scene> parse(std::string_view text, const std::filesystem::path& path);

}  // namespace copresence::scene
