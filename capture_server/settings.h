#pragma once

// The checked settings of capture_server, from its command line and its files.

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

/// `name` defaults to the recording's file name without its extension, or to a name for the camera.
struct ServerSettings : EncodingSettings {
  std::string source;  ///< The argument of sensor::open_source().
  std::string listen = "127.0.0.1:7001";
  bool loop = false;
  sensor::CameraControls controls;
  sensor::SourceSettings::Pace pace = sensor::SourceSettings::Pace::kReal;
  /// Unix time in seconds at which a recording begins. By default the recording begins at once.
  std::optional<double> start_at;
  std::optional<std::uint64_t> frames;  ///< The server ends after this many captured frames.
  bool insecure = false;
  std::string key;     ///< Path of the room's key file, or empty.
  std::string scene;   ///< Path of the scene file, or empty.
  std::string record;  ///< Path of the .oni file to record to, or empty.
  std::string config;  ///< Path of the settings file, or empty.
  bool list = false;
  std::string make_key;  ///< If not empty, the program only makes a key file at this path.

  /// The text of every setting, given or default, by its flag's name without the dashes. The text
  /// is empty if the setting is not set. The map is used for messages about changed settings.
  std::map<std::string, std::string> texts;

  /// True if a recording is played as fast as frames can be sent, without dropping any.
  bool keeps_every_frame() const;
};

/// Declares the flags on `app`. Parsing the flags writes into `settings`, which outlives `app`.
void add_flags(CLI::App& app, ServerSettings& settings);

/// Reads the command line, the file of --config and the scene file, in this order of priority. The
/// scene file contributes the source, the listening
/// address and the key. The keys in the file of
/// --config are the flags' names (settings_file.h). Relative paths in that file are relative to its
/// folder. Returns the settings. After --help, --version or a mistake, it prints the text or the
/// reason and returns the exit code: 0, 1 or 2.
tl::expected<ServerSettings, int> read_command_line(int argc, const char* const* argv);

/// Reads the settings again, with the present content of the files. Requires a command line that
/// read_command_line() accepted.
/// Fails with kInvalid and a sentence if a file is no longer valid.
Result<ServerSettings> read_again(int argc, const char* const* argv);

}  // namespace copresence::server
