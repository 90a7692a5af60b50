#pragma once

// Finds recordings of real sensors for tests and benchmarks. These recordings are not part of the
// project.

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace copresence::test {

/// Returns the path of one of these recordings, in the folder $COPRESENCE_RECORDINGS or in
/// ../shared/recordings beside the project. Returns nothing if this machine has none; then skip the
/// test with a message.
inline std::optional<std::string> real_recording(const std::string& name) {
  const char* folder = std::getenv("COPRESENCE_RECORDINGS");
  const std::filesystem::path path = std::filesystem::path(folder ? folder : "../shared/recordings") / name;
  return std::filesystem::exists(path) ? std::optional(path.string()) : std::nullopt;
}

}  // namespace copresence::test
