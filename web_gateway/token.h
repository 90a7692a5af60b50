#pragma once

// The token that viewers of a room need. It stands in the link that they open: #token=... A browser
// never sends this part of a link to a server, so it is in no server's log. Thread: pure functions.
//
// A token file has one line, 64 hexadecimal digits of 32 random bytes. Only the file's owner may be
// able to read it.

#include <filesystem>
#include <string>

#include "common/result.h"

namespace copresence::gateway {

/// Reads a token file. Fails with kNotFound without one, with kUnavailable if it cannot be read,
/// and with kInvalid if other users can read it or if it is no token file.
Result<std::string> read_token(const std::filesystem::path& path);

/// Writes a new random token to `path`, readable by the owner only. Fails with kInvalid if the file
/// exists, and with kUnavailable if it cannot be written.
Result<void> make_token(const std::filesystem::path& path);

}  // namespace copresence::gateway
