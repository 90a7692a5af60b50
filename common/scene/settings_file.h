#pragma once

// A program's settings as people write them: one TOML table of keys with plain values, `depth-kbps = 1500`. What keys there are and
// what they mean is the program's to say; where they stand is told with them, so that it can.
//
// Thread: pure.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::scene {

struct Setting {
  std::string key;
  std::string value;  ///< as on a command line: texts without quotes, true or false
  int line = 0;       ///< of the file, from 1

  friend bool operator==(const Setting&, const Setting&) = default;
};

/// The settings in the order of their lines. Fails (kInvalid) with FILE:LINE where it is no TOML, a key comes twice or a value is
/// neither text, number, true nor false.
Result<std::vector<Setting>> parse_settings(std::string_view text, const std::filesystem::path& path);

/// Fails (kNotFound) where there is no such file, and as parse_settings() does.
Result<std::vector<Setting>> load_settings(const std::filesystem::path& path);

}  // namespace copresence::scene
