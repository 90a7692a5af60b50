#pragma once

// Small text files that only their owner may read: room keys and tokens. No error message contains
// text from such a file. Thread: pure functions.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::text {

/// Number of hexadecimal digits of a secret, which has 32 random bytes.
inline constexpr std::size_t kSecretDigits = 64;

/// Reads a whole file. `as` names its kind in error messages, for example "a key file". Fails as
/// read_text_file() does, and with kInvalid if other users may read or change the file.
Result<std::string> read_secret_file(const std::filesystem::path& path, std::string_view as);

/// Writes `text` to a new file that only its owner can read. Never overwrites: fails with kInvalid
/// if the file exists. Fails with kUnavailable if it cannot be written. `what` names the content in
/// error messages, for example "key".
Result<void> write_secret_file(const std::filesystem::path& path, std::string_view text,
                               std::string_view what);

/// Returns a new random secret, kSecretDigits lower-case hexadecimal digits. Fails with
/// kUnavailable if the system gives no random bytes.
Result<std::string> make_secret();

/// Overwrites a secret in memory.
void wipe(std::string& text);

}  // namespace copresence::text
