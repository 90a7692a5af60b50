#pragma once

// The command line of capture_server, and its settings file, as one checked, plain struct.

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "capture_server/hole_filling/hole_filler.h"
#include "capture_server/sensor/frame_source.h"
#include "common/frame/depth_unit.h"
#include "common/result.h"

namespace copresence::server {

/// What the pictures may cost: all of it can change while the server runs.
struct EncoderSettings {
  int depth_qp = 20;              ///< 0 (lossless) to 51
  std::optional<int> depth_kbps;  ///< everything depth costs; instead of depth_qp
  int color_kbps = 2500;

  bool is_lossless() const { return depth_qp == 0 && !depth_kbps; }
  friend bool operator==(const EncoderSettings&, const EncoderSettings&) = default;
};

struct ServerSettings {
  std::string source;  ///< openni:, openni:URI or a recording's path
  std::string listen = "127.0.0.1:7001";
  std::string name;  ///< the camera's; the recording's file name without its ending by default
  std::string codec = "adaptive";
  EncoderSettings rates;
  hole_filling::Method hole_filling = hole_filling::Method::kJoint;
  DepthRange range;
  hole_filling::Compute compute = hole_filling::Compute::kAuto;
  bool loop = false;
  sensor::CameraControls controls;
  sensor::SourceSettings::Pace pace = sensor::SourceSettings::Pace::kReal;
  std::optional<double> start_at;       ///< Unix time, seconds: when a recording begins; at once by default
  std::optional<std::uint64_t> frames;  ///< end after so many captured frames
  bool insecure = false;
  std::string scene;   ///< scene file; empty for none
  std::string record;  ///< .oni file to record to; empty for none
  std::string config;  ///< settings file; empty for none
  bool list = false;

  /// Every setting as it was given, or as it is by default, by its flag's name without the dashes: to say what changed. Empty where
  /// it is not set.
  std::map<std::string, std::string> texts;
};

/// What the command line, the file of --config and the scene file ask for. The first that says something wins; the scene
/// file gives source and listening address. Returns settings to run with, or an exit code after --help, --version or a
/// mistake (0, 1 or 2, already explained on the terminal).
/// The file has the flags' names as keys (settings_file.h); a relative path in it is relative to it.
tl::expected<ServerSettings, int> read_command_line(int argc, const char* const* argv);

/// The same from the file as it is now. Fails (kInvalid) with a sentence where it is no longer what it must be.
/// Requires a command line that read_command_line() took.
Result<ServerSettings> read_again(int argc, const char* const* argv);

}  // namespace copresence::server
