// A file that somebody takes for a key file. The parser must not crash. The digits of a key that it
// accepts must be in the file. Its error messages must not contain any of the file's text, so there
// are only three of them.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <set>
#include <string>

#include "common/tls/room_key.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace copresence::tls;
  static std::set<std::string> messages;
  std::string text(reinterpret_cast<const char*>(data), size);
  const auto key = parse_key(text, "room.key");
  if (!key) {
    messages.insert(key.error().what);
    if (messages.size() > 3) std::abort();
    return 0;
  }
  std::string digits;
  for (const std::uint8_t byte : key->bytes()) digits += fmt::format("{:02x}", byte);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  if (text.find(digits) == std::string::npos) std::abort();
  return 0;
}
