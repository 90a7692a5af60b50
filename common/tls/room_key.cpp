#include "common/tls/room_key.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"

namespace copresence::tls {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 4096, kMostOfAPath = 300;
constexpr std::size_t kDigits = 2 * RoomKey::kBytes;
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

void wipe(std::string& text) {
  ::explicit_bzero(text.data(), text.size());
}

Result<void> write_whole(int descriptor, std::string_view text, const fs::path& path) {
  const auto failed = [&] {
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the key cannot be written: {}", name_of(path),
                                                     std::generic_category().message(errno)));
  };
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return failed();
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::fsync(descriptor) != 0) return failed();
  return {};
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
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;
  if (status.type() == fs::file_type::regular && (status.permissions() & kOthers) != fs::perms::none) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: other users of this machine may read or change this key: chmod 600 {}",
                            name_of(path), name_of(path)));
  }
  auto text = text::read_text_file(path, "a key file", kMostBytes);
  if (!text) return fail(text.error());
  auto key = parse_key(*text, path);
  wipe(*text);
  return key;
}

Result<void> make_key(const fs::path& path) {
  std::array<std::uint8_t, RoomKey::kBytes> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0)
    return fail(ErrorCode::kUnavailable, "the system gives no random bytes for a key");
  std::string text(kHeading);
  text.reserve(kHeading.size() + kDigits + 1);
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  text += '\n';
  ::explicit_bzero(bytes.data(), bytes.size());

  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    const int problem = errno;
    wipe(text);
    if (problem == EEXIST) {
      return fail(
          ErrorCode::kInvalid,
          fmt::format("{}: exists already and is kept; give another name for the new key", name_of(path)));
    }
    return fail(ErrorCode::kUnavailable, fmt::format("{}: the key cannot be written: {}", name_of(path),
                                                     std::generic_category().message(problem)));
  }
  auto written = write_whole(descriptor, text, path);
  wipe(text);
  ::close(descriptor);
  if (!written) ::unlink(path.c_str());
  return written;
}

}  // namespace copresence::tls
