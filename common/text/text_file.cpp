#include "common/text/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "common/text/excerpt.h"

namespace copresence::text {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfAPath = 300;

}  // namespace

Result<std::string> read_text_file(const fs::path& path, std::string_view as, std::size_t most_bytes) {
  const std::string name = excerpt(path.string(), kMostOfAPath);
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (status.type() == fs::file_type::not_found) {
    return fail(ErrorCode::kNotFound, fmt::format("there is no file {}: {} was expected there", name, as));
  }
  if (status.type() == fs::file_type::directory) {
    return fail(ErrorCode::kNotFound, fmt::format("{} is a folder, not {}", name, as));
  }
  if (status.type() == fs::file_type::none) {
    return fail(ErrorCode::kUnavailable,
                fmt::format("{}: cannot be read as {}: {}", name, as, problem.message()));
  }
  if (status.type() != fs::file_type::regular) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: is not a regular file, so not {}", name, as));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  // Read one byte too many to detect a larger file. The file system may report a wrong size.
  std::string text(most_bytes + 1, '\0');
  if (file) file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad()) {
    return fail(ErrorCode::kUnavailable, fmt::format("{}: cannot be read as {}: {}", name, as,
                                                     std::generic_category().message(errno)));
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > most_bytes) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is larger than {} kB, too large for {}", name, most_bytes / 1024, as));
  }
  return text;
}

}  // namespace copresence::text
