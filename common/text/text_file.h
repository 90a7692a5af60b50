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

/// Reads a whole regular file. `as` names the kind of file in error messages, for example "a scene
/// file". Fails with kNotFound if the file does not exist or is not regular, kUnavailable if it
/// cannot be read, kInvalid if it has more than `most_bytes`.
Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view as,
                                   std::size_t most_bytes = kMostBytes);

}  // namespace copresence::text
