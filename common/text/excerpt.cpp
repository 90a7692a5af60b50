#include "common/text/excerpt.h"

#include <fmt/format.h>

#include <algorithm>

namespace copresence::text {
namespace {

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7F;
}

bool continues_a_character(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

}  // namespace

std::string excerpt(std::string_view text, std::size_t most) {
  std::size_t end = std::min(text.size(), most);
  if (end < text.size()) {
    while (end > 0 && continues_a_character(text[end])) --end;
  }
  std::string quoted(text.substr(0, end));
  std::replace_if(quoted.begin(), quoted.end(), is_control, '?');
  return end == text.size() ? quoted : fmt::format("{}... ({} bytes)", quoted, text.size());
}

}  // namespace copresence::text
