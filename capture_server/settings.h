#pragma once

// The settings of capture_server, from its command line and files, checked.

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "capture_server/encoding/encoder_settings.h"
#include "capture_server/sensor/frame_source.h"
#include "common/result.h"

namespace CLI {
class App;
}

namespace copresence::server {

/// `name` defaults to the recording's file name without its ending, or to a name for the camera.
struct ServerSettings : EncodingSettings {
  std::string source;  ///< as sensor::open_source()
  std::string listen = "127.0.0.1:7001";
  bool loop = false;
  sensor::CameraControls controls;
  sensor::SourceSettings::Pace pace = sensor::SourceSettings::Pace::kReal;
  std::optional<double> start_at;  ///< Unix time in seconds at which a recording begins; at once by default
  std::optional<std::uint64_t> frames;  ///< end after this many captured frames
  bool insecure = false;
  std::string scene;   ///< scene file; empty for none
  std::string record;  ///< .oni file to record to; empty for none
  std::string config;  ///< settings file; empty for none
  bool list = false;

  /// The text of every setting, given or default, by its flag's name without the dashes; empty if
  /// it is not set. For messages about what changed.
  std::map<std::string, std::string> texts;

  /// Whether a recording is played as fast as frames can be encoded and sent, so that none is
  /// dropped.
  bool keeps_every_frame() const;
};

/// Declares the flags on `app`; they write into `settings`, which outlives `app`.
void add_flags(CLI::App& app, ServerSettings& settings);

/// Reads the command line, the file of --config and the scene file. Of these the first that has a
/// setting wins; the scene file has only source and listening address. The file of --config has the
/// flags' names as keys (settings_file.h); a relative path in it is relative to its
/// folder.
/// Returns the settings, or an exit code after --help, --version or a mistake (0, 1 or 2, already
/// explained on the terminal).
tl::expected<ServerSettings, int> read_command_line(int argc, const char* const* argv);

/// The same with the present content of the files. Fails (kInvalid) with a sentence if they are no
/// longer valid. Requires a command line that read_command_line() accepted.
Result<ServerSettings> read_again(int argc, const char* const* argv);

}  // namespace copresence::server
