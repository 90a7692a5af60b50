#include "capture_server/settings_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"
#include "common/toml/parse_toml.h"

namespace copresence::server {
namespace {

std::optional<std::string> plain_text(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  return std::nullopt;
}

}  // namespace

Result<std::vector<Setting>> parse_settings(std::string_view text, const std::filesystem::path& path) {
  const auto root = parse_toml(text, path);
  if (!root) return fail(root.error());
  std::vector<Setting> settings;
  for (const auto& [key, node] : *root) {
    const int line = static_cast<int>(key.source().begin.line);
    auto value = plain_text(node);
    if (!value) {
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: \"{}\" must be a text, a number, true or false",
                                                   path.string(), line, text::excerpt(key.str())));
    }
    settings.push_back({std::string(key.str()), std::move(*value), line});
  }
  std::sort(settings.begin(), settings.end(),
            [](const Setting& a, const Setting& b) { return a.line < b.line; });
  return settings;
}

Result<std::vector<Setting>> load_settings(const std::filesystem::path& path) {
  const auto text = text::read_text_file(path, "a settings file");
  if (!text) return fail(text.error());
  return parse_settings(*text, path);
}

}  // namespace copresence::server
