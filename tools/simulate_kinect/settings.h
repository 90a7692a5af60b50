#pragma once

// The validated command line of simulate_kinect.

#include <cstdint>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "common/frame/depth_unit.h"

namespace copresence::simulate_kinect {

struct Settings {
  std::string world;
  int cameras = 2;
  int frames = 60;
  std::filesystem::path folder;
  bool overwrite = false;
  std::uint32_t seed = 1;
  int width = 640, height = 480;
  DepthUnit unit = DepthUnit::kMillimetre;
  int jpeg_quality = 85;
  bool truth = false;
  std::vector<std::filesystem::path> truth_views;  ///< Path files of additional viewpoints.
  int truth_width = 1280, truth_height = 720;      ///< Size of these views, pixels.
  double truth_fov_deg = 50;                       ///< Vertical field of view of these viewpoints, degrees.
};

/// Returns the settings, or an exit code: 0 after --help and --version, 2 after an invalid command
/// line. Errors are reported on standard error.
tl::expected<Settings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::simulate_kinect
