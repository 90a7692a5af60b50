#pragma once

// Text from strangers ends on terminals and in logs: UTF-8 without characters that control either.
// Thread: pure functions.

#include <cstddef>
#include <string>
#include <string_view>

namespace copresence::wire {

/// Valid UTF-8 without C0 and C1 control characters and DEL, Unicode's line and paragraph separators, and the
/// characters that turn the direction of text.
bool is_printable(std::string_view text);

/// The same text with a `?` for every byte that is not part of a printable character, cut between two
/// characters to at most `max_bytes`.
std::string made_printable(std::string_view text, std::size_t max_bytes);

}  // namespace copresence::wire
