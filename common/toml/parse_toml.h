#pragma once

// Parses TOML files that other people wrote.
//
// toml++ has no limit on dotted keys and frees nested tables by recursion, so a file with
// `[a.a.a...` overflows the stack. Nesting is therefore checked before toml++ sees the text.
// Thread: pure functions.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence {

/// The largest number of parts in a dotted key, and of lists and tables inside each other.
inline constexpr int kMostTomlLevels = 16;

/// Parses `text`; errors name `path`. Fails with kInvalid and `PATH:LINE: reason`, of bounded
/// length, if the text is no TOML, is larger than text::kMostBytes or nests deeper than
/// kMostTomlLevels.
Result<toml::table> parse_toml(std::string_view text, const std::filesystem::path& path);

}  // namespace copresence
