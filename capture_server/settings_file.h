#pragma once

// Reads a file with settings of the server. The file is one TOML table of keys with plain values,
// such as `depth-kbps = 1500`. settings.h checks the keys.
// Thread: pure functions, safe anywhere.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::server {

struct Setting {
  std::string key;
  std::string value;  ///< The value as on a command line: text without quotes, a number, true or false.
  int line = 0;       ///< Line in the file, from 1.

  friend bool operator==(const Setting&, const Setting&) = default;
};

/// Returns the settings in the order of their lines.
/// Fails with kInvalid and FILE:LINE if the text is not TOML or a key occurs twice. Also fails so
/// if a value is neither a text, a number, true nor false.
Result<std::vector<Setting>> parse_settings(std::string_view text, const std::filesystem::path& path);

/// Parses the file at `path`. Fails like parse_settings(), and with kNotFound if there is no file.
Result<std::vector<Setting>> load_settings(const std::filesystem::path& path);

}  // namespace copresence::server
