#pragma once

// Makes untrusted text safe for logs, terminals and error messages. Thread: pure functions.

#include <cstddef>
#include <string>
#include <string_view>

namespace copresence::text {

/// True for valid UTF-8 without characters that control a terminal or split a log line. Excluded
/// are C0 and C1 controls, DEL, Unicode's line and paragraph separators, and characters that
/// reverse the direction of text.
bool is_printable(std::string_view text);

/// Returns the text with a `?` for every byte that is not part of a printable character. The result
/// is cut between two characters to at most `max_bytes`.
std::string sanitise(std::string_view text, std::size_t max_bytes);

/// Returns the text for quoting in a message. It is sanitised. Text longer than `max_bytes` is cut
/// and followed by its length: `aaaa... (5000000 bytes)`.
std::string excerpt(std::string_view text, std::size_t max_bytes = 80);

}  // namespace copresence::text
