#pragma once

// TOML that others wrote, parsed without risk to the program. Of this room only.
//
// toml++ frees nested tables by recursion and has no limit on dotted keys, so `[a.a.a...` overflows the stack.
//
// Thread: pure.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::scene {

/// How deep a key may be dotted, and how deep lists and tables may nest.
inline constexpr int kMostLevels = 16;

/// Fails (kInvalid) with `PATH:LINE: what`, of bounded length, where the text is no TOML, is larger than
/// text::kMostBytes or nests deeper than kMostLevels.
Result<toml::table> parse_toml(std::string_view text, const std::filesystem::path& path);

}  // namespace copresence::scene
