#include "common/tls/room_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>

#include "common/text/excerpt.h"
#include "common/text/secret_file.h"

namespace copresence::tls {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfAPath = 300;
constexpr std::size_t kDigits = 2 * RoomKey::kBytes;
static_assert(kDigits == text::kSecretDigits);
constexpr std::string_view kHeading =
    "# Copresence room key. Whoever has this file can watch the room: keep it secret.\n";

std::string name_of(const fs::path& path) {
  return text::excerpt(path.string(), kMostOfAPath);
}

std::optional<std::uint8_t> value_of(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return std::nullopt;
}

/// Returns the next line of `text` without its end, and removes it from `text`.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t'))
    line.remove_suffix(1);
  return line;
}

}  // namespace

RoomKey::~RoomKey() {
  ::explicit_bzero(bytes_.data(), bytes_.size());
}

Result<RoomKey> parse_key(std::string_view text, const fs::path& path) {
  const auto wrong = [&](std::string_view what) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {}, so it is not a key file: capture_server --make-key FILE makes one",
                            name_of(path), what));
  };
  std::optional<RoomKey> key;
  while (!text.empty()) {
    const std::string_view line = take_line(text);
    if (line.empty() || line.front() == '#') continue;
    if (key) return wrong("it has more than one line that is no comment");
    if (line.size() != kDigits) return wrong(fmt::format("it has no line of {} hexadecimal digits", kDigits));
    std::array<std::uint8_t, RoomKey::kBytes> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const auto high = value_of(line[2 * i]), low = value_of(line[2 * i + 1]);
      if (!high || !low) return wrong("its line has other characters than hexadecimal digits");
      bytes[i] = static_cast<std::uint8_t>(*high << 4 | *low);
    }
    key.emplace(bytes);
    ::explicit_bzero(bytes.data(), bytes.size());
  }
  if (!key) return wrong(fmt::format("it has no line of {} hexadecimal digits", kDigits));
  return *key;
}

Result<RoomKey> read_key(const fs::path& path) {
  auto text = text::read_secret_file(path, "a key file");
  if (!text) return fail(text.error());
  auto key = parse_key(*text, path);
  text::wipe(*text);
  return key;
}

Result<void> make_key(const fs::path& path) {
  auto digits = text::make_secret();
  if (!digits) return fail(digits.error());
  std::string text = fmt::format("{}{}\n", kHeading, *digits);
  auto written = text::write_secret_file(path, text, "key");
  text::wipe(text);
  text::wipe(*digits);
  return written;
}

}  // namespace copresence::tls
