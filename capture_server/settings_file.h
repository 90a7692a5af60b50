#pragma once

// A file with settings of the server: one TOML table of keys with plain values, such as `depth-kbps = 1500`.
// This part reads keys and values with their lines. settings.h knows which keys there are.
//
// Thread: pure functions.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::server {

struct Setting {
  std::string key;
  std::string value;  ///< as on a command line: texts without quotes, true or false
  int line = 0;       ///< in the file, from 1

  friend bool operator==(const Setting&, const Setting&) = default;
};

/// The settings in the order of their lines. Fails with kInvalid and FILE:LINE if the text is no TOML, a key
/// comes twice or a value is neither a text, a number, true nor false.
Result<std::vector<Setting>> parse_settings(std::string_view text, const std::filesystem::path& path);

/// The same on a file. Fails with kNotFound if there is no such file, and as parse_settings() does.
Result<std::vector<Setting>> load_settings(const std::filesystem::path& path);

}  // namespace copresence::server
