#pragma once

// The command line of capture_server as one checked, plain struct.

#include <cstdint>
#include <optional>
#include <string>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/sensor/frame_source.h"
#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::server {

struct ServerSettings {
  std::string source;  ///< openni:, openni:URI or a recording's path
  std::string listen = "127.0.0.1:7001";
  std::string name;  ///< the camera's; the recording's file name without its ending by default
  std::string codec = "adaptive";
  int depth_qp = 20;              ///< 0 (lossless) to 51
  std::optional<int> depth_kbps;  ///< everything depth costs; instead of depth_qp
  int color_kbps = 2500;
  hole_filling::Method hole_filling = hole_filling::Method::kJoint;
  DepthRange range;
  hole_filling::Compute compute = hole_filling::Compute::kAuto;
  bool loop = false;
  sensor::CameraControls controls;
  sensor::SourceSettings::Pace pace = sensor::SourceSettings::Pace::kReal;
  std::optional<std::uint64_t> frames;  ///< end after so many captured frames
  bool insecure = false;
  std::string scene;   ///< scene file; empty for none
  std::string record;  ///< .oni file to record to; empty for none
  bool list = false;
};

/// What the command line asks for: settings to run with, or an exit code after --help, --version or a mistake
/// (0 or 2, already explained on the terminal).
tl::expected<ServerSettings, int> read_command_line(int argc, const char* const* argv);

}  // namespace copresence::server
