#include "common/toml/parse_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"

namespace copresence {
namespace {

constexpr std::size_t kMostOfADescription = 300;

/// Counts the nesting of keys and brackets in a TOML text. Skips strings and comments.
class NestingScan {
 public:
  explicit NestingScan(std::string_view text) : text_(text) {}

  /// Returns the number of the first line that nests too deep, if any.
  std::optional<int> first_too_deep() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        skip_to_end_of_line();
        continue;
      }
      if (c == '\n') ++line_;
      if (c == '.') ++dots_;
      if (c == '\n' || c == '=' || c == ',' || c == '[' || c == '{') dots_ = 0;
      if (c == '[' || c == '{') ++brackets_;
      if (c == ']' || c == '}') brackets_ = std::max(brackets_ - 1, 0);
      if (dots_ >= kMostTomlLevels || brackets_ > kMostTomlLevels) return line_;
      ++at_;
    }
    return std::nullopt;
  }

 private:
  void skip_to_end_of_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }

  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(at_).starts_with(three);
    at_ += is_long ? 3 : 1;
    while (at_ < text_.size()) {
      if (is_long ? text_.substr(at_).starts_with(three) : text_[at_] == quote) {
        at_ += is_long ? 3 : 1;
        // The content of a long string may end with up to two quotes.
        for (int own = 0; is_long && own < 2 && text_.substr(at_).starts_with(quote); ++own) ++at_;
        return;
      }
      if (text_[at_] == '\n' && !is_long) return;  // The string is unfinished, so the parser will fail on it.
      if (quote == '"' && text_[at_] == '\\') next_character();
      next_character();
    }
  }

  void next_character() {
    if (at_ < text_.size() && text_[at_++] == '\n') ++line_;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1, dots_ = 0, brackets_ = 0;
};

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::filesystem::path& path) {
  const auto wrong = [&](auto line, const std::string& what) {
    return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", path.string(), line, what));
  };
  if (text.size() > text::kMostBytes) {
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: is larger than {} kB", path.string(), text::kMostBytes / 1024));
  }
  if (const auto line = NestingScan(text).first_too_deep()) {
    return wrong(*line, fmt::format("keys or lists are nested more than {} levels deep", kMostTomlLevels));
  }
  try {
    return toml::parse(text, path.string());
  } catch (const toml::parse_error& error) {
    return wrong(error.source().begin.line, text::excerpt(error.description(), kMostOfADescription));
  }
}

}  // namespace copresence
