#pragma once

// Writes one JSON object as text. The page reads the results of the exported functions in this form.
// Numbers must be finite. Thread: one thread at a time.

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>

namespace copresence::web {

class JsonObject {
 public:
  JsonObject& add(std::string_view key, double number) { return add_raw(key, fmt::format("{}", number)); }
  JsonObject& add(std::string_view key, bool value) { return add_raw(key, value ? "true" : "false"); }
  JsonObject& add(std::string_view key, std::string_view text) { return add_raw(key, quoted(text)); }
  JsonObject& add(std::string_view key, const char* text) { return add(key, std::string_view(text)); }
  JsonObject& add(std::string_view key, const JsonObject& object) { return add_raw(key, object.text()); }
  JsonObject& add(std::string_view key, std::span<const double> numbers) {
    return add_raw(key, fmt::format("[{}]", fmt::join(numbers.begin(), numbers.end(), ",")));
  }
  /// Adds the address and the length of memory that the page reads.
  template <class Element>
  JsonObject& add_memory(std::string_view key, std::span<Element> elements) {
    return add_raw(
        key, fmt::format("[{},{}]", reinterpret_cast<std::uintptr_t>(elements.data()), elements.size()));
  }

  std::string text() const { return "{" + members_ + "}"; }

 private:
  JsonObject& add_raw(std::string_view key, std::string_view value) {
    members_ += fmt::format("{}\"{}\":{}", members_.empty() ? "" : ",", key, value);
    return *this;
  }

  static std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte < 0x20) {
        result += fmt::format("\\u{:04x}", byte);
        continue;
      }
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
    return result + '"';
  }

  std::string members_;
};

}  // namespace copresence::web
