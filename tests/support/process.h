#pragma once

// Starts real programs for tests, reads their output and ends them.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace copresence::testing {

/// Returns build/<preset>/bin/NAME of this build.
std::filesystem::path program(const std::string& name);

/// Returns the project's folder data/recordings.
std::filesystem::path recordings();

/// A new empty folder. The destructor removes it with its content.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Returns a TCP port of the loopback address that was free a moment ago.
int free_port();

/// A running program. The destructor kills it and its children.
class Process {
 public:
  /// `arguments[0]` is the program. Its standard output and error go to one file, which output()
  /// reads. `environment` has additional variables as NAME=VALUE.
  explicit Process(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;
  void signal_group(int number) const;  ///< Signals the program and its children.

  /// Returns the only child. Waits for it, and fails the test if there is none within ten seconds.
  pid_t child() const;

  /// Returns the exit code, or 128 plus the number of the signal that ended the program. Returns
  /// nothing if the program still runs after `timeout`.
  std::optional<int> wait(std::chrono::milliseconds timeout);

  /// Returns all output so far.
  std::string output() const;

  /// Returns true once the output contains `text`, or false after `timeout`.
  bool says(const std::string& text, std::chrono::milliseconds timeout) const;

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

}  // namespace copresence::testing
