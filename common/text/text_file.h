#pragma once

// Thread: pure.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::text {

/// What people write by hand is far below this.
inline constexpr std::size_t kMostBytes = 1 << 20;

/// All of a regular file.
///
/// as      what the file should be, for the sentence: "a scene file"
/// Fails   kNotFound where it is not there or no regular file, kUnavailable where it cannot be read, kInvalid where it has
///         more than `most_bytes`.
Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view as,
                                   std::size_t most_bytes = kMostBytes);

}  // namespace copresence::text
