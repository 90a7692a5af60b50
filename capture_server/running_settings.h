#pragma once

// The settings of a running server. Its settings file can be read again; settings that need no
// restart then take effect.
//
// Thread: read_again() on the thread of signals, everything else on any.

#include <mutex>
#include <string>
#include <vector>

#include "capture_server/settings.h"
#include "common/flow/mailbox.h"

namespace copresence::server {

/// The difference between running and new settings. Only encoder settings take effect without a
/// restart.
struct SettingsChange {
  ServerSettings settings;                   ///< the running settings with the new encoder settings
  std::vector<std::string> at_once;          ///< changes that take effect: "depth-kbps 4000 -> 1500"
  std::vector<std::string> after_a_restart;  ///< changes that do not
};

/// Pure.
SettingsChange change(const ServerSettings& running, const ServerSettings& wanted);

class RunningSettings {
 public:
  /// The activity of read_again(), for Heartbeat::doing().
  static constexpr const char* kReading = "reading the settings file of --config again";

  /// `argc` and `argv` are a command line that read_command_line() accepted; they outlive this.
  /// `begun_with` is its result.
  RunningSettings(int argc, const char* const* argv, ServerSettings begun_with);

  /// Reads the settings file again, applies the changes and logs them. An invalid file is logged
  /// and changes nothing. While the file is still being written, it waits, at most 0.2 s.
  void read_again();

  ServerSettings now() const;

  /// New encoder settings for the encode stage.
  flow::Mailbox<EncoderSettings>& encoder_changes() { return encoder_changes_; }

 private:
  Result<ServerSettings> read_settled() const;

  const std::string file_;
  const int argc_;
  const char* const* const argv_;
  mutable std::mutex mutex_;
  ServerSettings now_;
  flow::Mailbox<EncoderSettings> encoder_changes_;
};

}  // namespace copresence::server
