#pragma once

// Parses TOML files that other people wrote. The library toml++ has no limit on dotted keys and
// frees nested tables by recursion, so a file with `[a.a.a...` overflows the stack. Nesting is
// therefore checked before toml++ sees the text. Thread: pure functions.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence {

/// Largest number of parts in a dotted key, and of lists and tables inside each other.
inline constexpr int kMostTomlLevels = 16;

/// Parses `text`. Error messages name `path`. Fails with kInvalid and a short message `PATH:LINE:
/// reason` if the text is not TOML, exceeds text::kMostBytes or nests deeper than kMostTomlLevels.
Result<toml::table> parse_toml(std::string_view text, const std::filesystem::path& path);

}  // namespace copresence
