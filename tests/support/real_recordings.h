#pragma once

// Where recordings of real sensors lie, for tests and benchmarks that need reality. They are no part of the project.

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace copresence::test {

/// The path of one of them: in $COPRESENCE_RECORDINGS, else in ../shared/recordings seen from the project's root.
/// Nothing where this machine has none; then skip loudly.
inline std::optional<std::string> real_recording(const std::string& name) {
  const char* folder = std::getenv("COPRESENCE_RECORDINGS");
  const std::filesystem::path path = std::filesystem::path(folder ? folder : "../shared/recordings") / name;
  return std::filesystem::exists(path) ? std::optional(path.string()) : std::nullopt;
}

}  // namespace copresence::test
