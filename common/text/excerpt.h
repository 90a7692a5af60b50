#pragma once

// Thread: pure.

#include <cstddef>
#include <string>
#include <string_view>

namespace copresence::text {

/// `text` as a sentence may quote it. A longer one than `most` bytes is cut there (between UTF-8 characters) and its
/// length is given: `aaaa... (5000000 bytes)`. Control characters become '?', so that no file writes to a terminal.
std::string excerpt(std::string_view text, std::size_t most = 80);

}  // namespace copresence::text
