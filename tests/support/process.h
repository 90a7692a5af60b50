#pragma once

// Real processes for tests: start one, read what it says, end it.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace copresence::testing {

/// build/<preset>/bin/NAME of this build.
std::filesystem::path program(const std::string& name);

/// The project's data/recordings.
std::filesystem::path recordings();

/// A new empty folder, removed with everything in it at the end.
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

/// A TCP port of the loopback address that was free a moment ago.
int free_port();

/// A running program; killed, children and all, when this goes.
class Process {
 public:
  /// `arguments[0]` is the program. Its standard output and error go to one file that output() reads.
  /// `environment`: variables that it gets besides those of the test, NAME=VALUE.
  explicit Process(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void signal(int number) const;
  void signal_group(int number) const;  ///< the program and its children

  /// Its only child; waits for one, and fails the test where none comes within ten seconds.
  pid_t child() const;

  /// Exit code; 128 + the signal's number where one ended it; nothing when it still runs after `timeout`.
  std::optional<int> wait(std::chrono::milliseconds timeout);

  /// Everything it has said so far.
  std::string output() const;

  /// Whether it says `text` within `timeout`.
  bool says(const std::string& text, std::chrono::milliseconds timeout) const;

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

}  // namespace copresence::testing
