#include "web_gateway/token.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "common/text/excerpt.h"
#include "common/text/secret_file.h"

namespace copresence::gateway {

Result<std::string> read_token(const std::filesystem::path& path) {
  const auto text = text::read_secret_file(path, "a token file");
  if (!text) return fail(text.error());
  std::string_view token = *text;
  while (token.ends_with('\n') || token.ends_with('\r')) token.remove_suffix(1);
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (token.size() != text::kSecretDigits || !std::all_of(token.begin(), token.end(), is_digit)) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is no token file, which has one line of {} digits 0 to 9 and a to f: "
                            "web_gateway --make-token FILE makes one",
                            text::excerpt(path.string(), 300), text::kSecretDigits));
  }
  return std::string(token);
}

Result<void> make_token(const std::filesystem::path& path) {
  auto token = text::make_secret();
  if (!token) return fail(token.error());
  *token += '\n';
  return text::write_secret_file(path, *token, "token");
}

}  // namespace copresence::gateway
