#pragma once

// The command line of record, checked.

#include <array>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "common/frame/depth_unit.h"
#include "tools/record/time_reading.h"

namespace copresence::record {

struct InfoSettings {
  std::string recording;
  bool json = false;
};

struct RepairSettings {
  std::string recording;
  std::string out;  ///< empty: in place
  bool overwrite = false;
};

struct CutSettings {
  std::string recording, out;
  double from_s = 0;           ///< seconds after the first frame
  std::optional<double> to_s;  ///< likewise; the recording's end where not given
  bool overwrite = false;
};

struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels of the depth images
  std::array<double, 8> distortion{};     ///< OpenCV's order
};

struct FromImagesSettings {
  std::string folder, out;
  std::string name;               ///< of the camera; the folder's by default
  double frames_per_second = 30;  ///< where the images have no times
  std::optional<TimeUnit> times;  ///< what numbers in lists and names are; recognised where not given
  std::string depth, color;       ///< folders or groups of images to take; the likeliest where empty
  std::optional<double>
      depth_per_metre;  ///< what a depth of one metre is in the images; by the set where not given
  DepthUnit unit = DepthUnit::kMillimetre;
  std::optional<Intrinsics> intrinsics;  ///< a Kinect's where not given
  bool registered = true;                ///< colour is as the depth camera sees it
  int jpeg_quality = 95;
  bool overwrite = false;
};

using Settings = std::variant<InfoSettings, RepairSettings, CutSettings, FromImagesSettings>;

/// What is asked for, or the exit code to leave with: 0 after --help and --version, 2 after a wrong command line
/// (said on standard error).
tl::expected<Settings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::record
