#include "common/scene/text_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

namespace copresence::scene {

Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view as) {
  std::error_code ignored;
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  if (!file.is_open()) {
    return fail(ErrorCode::kNotFound, fmt::format("{}: cannot be read as {}", path.string(), as));
  }
  return std::string{std::istreambuf_iterator<char>(file), {}};
}

}  // namespace copresence::scene
