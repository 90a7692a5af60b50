#include "common/text/secret_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <system_error>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"

namespace copresence::text {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSecretBytes = 4096, kMostOfSecretPath = 300;

std::string name_of(const fs::path& path) {
  return excerpt(path.string(), kMostOfSecretPath);
}

tl::unexpected<Error> not_written(const fs::path& path, std::string_view what, int problem) {
  return fail(ErrorCode::kUnavailable, fmt::format("{}: the {} cannot be written: {}", name_of(path), what,
                                                   std::generic_category().message(problem)));
}

/// Returns 0, or the error number.
int write_whole(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return ::fsync(descriptor) == 0 ? 0 : errno;
}

}  // namespace

Result<std::string> read_secret_file(const fs::path& path, std::string_view as) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;
  if (status.type() == fs::file_type::regular && (status.permissions() & kOthers) != fs::perms::none) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: other users of this machine may read or change this "
                                                 "file, and {} must be secret: chmod 600 {}",
                                                 name_of(path), as, name_of(path)));
  }
  return read_text_file(path, as, kMostSecretBytes);
}

Result<void> write_secret_file(const fs::path& path, std::string_view text, std::string_view what) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0 && errno == EEXIST) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: exists already and is kept; give another name for the new {}", name_of(path), what));
  }
  if (descriptor < 0) return not_written(path, what, errno);
  const int problem = write_whole(descriptor, text);
  ::close(descriptor);
  if (problem == 0) return {};
  ::unlink(path.c_str());
  return not_written(path, what, problem);
}

Result<std::string> make_secret() {
  std::array<std::uint8_t, kSecretDigits / 2> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0)
    return fail(ErrorCode::kUnavailable, "the system gives no random bytes for a secret");
  std::string digits;
  digits.reserve(kSecretDigits);
  for (const std::uint8_t byte : bytes) digits += fmt::format("{:02x}", byte);
  ::explicit_bzero(bytes.data(), bytes.size());
  return digits;
}

void wipe(std::string& text) {
  ::explicit_bzero(text.data(), text.size());
}

}  // namespace copresence::text
