#pragma once

// Reads small text files that people wrote. Thread: pure functions.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::text {

/// Files that people write by hand are much smaller.
inline constexpr std::size_t kMostBytes = 1 << 20;

/// Reads a whole regular file.
///
/// as      the kind of file for error messages: "a scene file"
/// Fails   kNotFound if it does not exist or is no regular file, kUnavailable if it cannot be read,
///         kInvalid if it has more than `most_bytes`.
Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view as,
                                   std::size_t most_bytes = kMostBytes);

}  // namespace copresence::text
