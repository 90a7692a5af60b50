#pragma once

// The validated command line of the program record.

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
  std::string out;  ///< Empty: repair in place.
  bool overwrite = false;
};

struct CutSettings {
  std::string recording, out;
  double from_s = 0;           ///< Seconds after the first frame.
  std::optional<double> to_s;  ///< Seconds, exclusive; the end of the recording if not given.
  bool overwrite = false;
};

struct Intrinsics {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< Intrinsics, in pixels of the depth images.
  std::array<double, 8> distortion{};     ///< Distortion k1 k2 p1 p2 k3 k4 k5 k6, as in OpenCV.
};

struct FromImagesSettings {
  std::string folder, out;
  std::string name;               ///< Name of the camera; that of camera.json or of the folder if empty.
  double frames_per_second = 30;  ///< Used if the images have no times.
  std::optional<TimeUnit> times;  ///< Unit of numbers in lists and names; recognised if not given.
  std::string depth, color;       ///< Folder or group of images to use; recognised if empty.
  std::optional<double> depth_per_metre;  ///< Pixel value of one metre; recognised if not given.
  std::optional<DepthUnit> unit;          ///< Millimetres if neither given nor in camera.json.
  std::optional<Intrinsics> intrinsics;   ///< Those of camera.json, or a Kinect's, if not given.
  bool registered = true;                 ///< True if colour has the viewpoint of the depth camera.
  int jpeg_quality = 95;
  bool overwrite = false;
};

enum class ExportFormat { kTum, k7Scenes };

struct ExportSettings {
  std::string recording;  ///< An .oni recording or a session recording (.mkv).
  std::string out;        ///< The folder to make.
  ExportFormat format = ExportFormat::kTum;
};

using Settings = std::variant<InfoSettings, RepairSettings, CutSettings, FromImagesSettings, ExportSettings>;

/// Returns the settings of one command, or an exit code: 0 after --help and --version, 2 after an
/// invalid command line. Errors are reported on standard error.
tl::expected<Settings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::record
