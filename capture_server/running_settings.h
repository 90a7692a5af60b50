#pragma once

// The settings of a server that runs: its file may be read again, and what can change without a restart does.
//
// Thread: read_again() on the thread of signals, everything else on any.

#include <mutex>
#include <string>
#include <vector>

#include "capture_server/settings.h"
#include "common/flow/mailbox.h"

namespace copresence::server {

/// What of new settings holds at once: the rates.
struct SettingsChange {
  ServerSettings settings;                   ///< to go on with: the running ones with the new rates
  std::vector<std::string> at_once;          ///< "depth-kbps 4000 -> 1500"
  std::vector<std::string> after_a_restart;  ///< of settings that stay as they were, likewise
};

/// Pure.
SettingsChange change(const ServerSettings& running, const ServerSettings& wanted);

class RunningSettings {
 public:
  /// What read_again() does, for sentences about it.
  static constexpr const char* kReading = "reading the settings file of --config again";

  /// Of a command line that read_command_line() took, and what it came to; it must live as long as this.
  RunningSettings(int argc, const char* const* argv, ServerSettings begun_with);

  /// Reads the settings file again and says in the log what changes and what would take a restart. Where it is not what it must be,
  /// one line says so and everything goes on as before. A file that is just being written is waited for, 0.2 s at most.
  void read_again();

  ServerSettings now() const;

  /// New rates, for whoever encodes.
  flow::Mailbox<EncoderSettings>& rates() { return rates_; }

 private:
  Result<ServerSettings> read_settled() const;

  const std::string file_;
  const int argc_;
  const char* const* const argv_;
  mutable std::mutex mutex_;
  ServerSettings now_;
  flow::Mailbox<EncoderSettings> rates_;
};

}  // namespace copresence::server
