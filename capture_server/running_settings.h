#pragma once

// The settings of a running server. The server can read its settings file again. Settings that need
// no restart then take effect.
// Thread: call read_again() on the thread that handles signals, and everything else on any thread.

#include <mutex>
#include <string>
#include <vector>

#include "capture_server/settings.h"
#include "common/flow/mailbox.h"

namespace copresence::server {

/// Difference between running and new settings. Only encoder settings need no restart.
struct SettingsChange {
  ServerSettings settings;                   ///< The running settings with the new encoder settings.
  std::vector<std::string> at_once;          ///< Changes that take effect, such as "depth-kbps 4000 -> 1500".
  std::vector<std::string> after_a_restart;  ///< Changes that need a restart.
};

/// Compares the running settings with the wanted ones. Changes nothing.
SettingsChange change(const ServerSettings& running, const ServerSettings& wanted);

class RunningSettings {
 public:
  /// The activity that Heartbeat::doing() reports during read_again().
  static constexpr const char* kReading = "reading the settings file of --config again";

  /// `argc` and `argv` are a command line that read_command_line() accepted. They outlive this
  /// object. `begun_with` is the result of read_command_line().
  RunningSettings(int argc, const char* const* argv, ServerSettings begun_with);

  /// Reads the settings file again, applies the changes and logs them. An invalid file is logged
  /// and changes nothing. If the file is being written, the function waits for at most 0.2 s.
  void read_again();

  ServerSettings now() const;

  /// Returns the mailbox from which the encode stage takes new encoder settings.
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
