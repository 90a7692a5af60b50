#include "common/text/excerpt.h"

#include <fmt/format.h>

#include <cstdint>

namespace copresence::text {
namespace {

/// True for characters that reverse the direction of the text after them. A name with such
/// characters could make a log line read differently.
bool reverses_text(std::uint32_t code) {
  return code == 0x061c || code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

/// Returns the size of the printable character at the start of `text`, or 0 if there is none.
std::size_t printable_character(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;

  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) return 0;
  std::uint32_t code = first & (0x7f >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  const bool control = code < 0xa0 || code == 0x2028 || code == 0x2029 || reverses_text(code);
  return code >= kSmallest[size] && code <= 0x10ffff && !surrogate && !control ? size : 0;
}

}  // namespace

bool is_printable(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = printable_character(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

std::string sanitise(std::string_view text, std::size_t max_bytes) {
  std::string out;
  while (!text.empty()) {
    const std::size_t size = printable_character(text);
    const std::string_view next = size ? text.substr(0, size) : std::string_view("?");
    if (out.size() + next.size() > max_bytes) break;
    out += next;
    text.remove_prefix(size ? size : 1);
  }
  return out;
}

std::string excerpt(std::string_view text, std::size_t max_bytes) {
  std::string quoted = sanitise(text, max_bytes);
  // Each unprintable byte becomes one byte, so only a cut makes the text shorter.
  return quoted.size() == text.size() ? quoted : fmt::format("{}... ({} bytes)", quoted, text.size());
}

}  // namespace copresence::text
