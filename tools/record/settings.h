#pragma once

// The command line of record, checked.

#include <array>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "common/frame/depth_unit.h"

namespace copresence::record {

struct InfoSettings {
  std::string recording;
  bool json = false;
};

struct RepairSettings {
  std::string recording;
  std::string out;  ///< empty: in place
};

struct CutSettings {
  std::string recording, out;
  double from_s = 0, to_s = 1e18;  ///< seconds after the first frame
};

struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels of the depth images
  std::array<double, 8> distortion{};     ///< OpenCV's order
};

struct FromImagesSettings {
  std::string folder, out;
  std::string name;               ///< of the camera; the folder's by default
  double frames_per_second = 30;  ///< where the images have no times
  std::optional<double>
      depth_per_metre;  ///< what a depth of one metre is in the PNGs; by the lists where not given
  DepthUnit unit = DepthUnit::kMillimetre;
  std::optional<Intrinsics> intrinsics;  ///< a Kinect's where not given
  bool registered = true;                ///< colour is as the depth camera sees it
  int jpeg_quality = 95;
};

using Settings = std::variant<InfoSettings, RepairSettings, CutSettings, FromImagesSettings>;

/// What is asked for, or the exit code to leave with: 0 after --help and --version, 2 after a wrong command line
/// (said on standard error).
tl::expected<Settings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::record
