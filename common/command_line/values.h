#pragma once

// Checks for the values of command-line options. Each check sees the text before it is converted.
// So an error message names the option, the given text and the allowed values:
//
//   capture_server: --depth-qp: "foo" is not a whole number from 0 to 51; see --help
//
// Thread: pure functions.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <concepts>
#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/frame/depth_unit.h"

namespace copresence::command_line {

/// For Option::check(): accepts a text if `is_one` returns true. Otherwise the error message is
/// `"TEXT" is not WHAT`. `--help` shows `in_help` after the option's type.
CLI::Validator must_be(std::string what, std::function<bool(const std::string&)> is_one,
                       std::string in_help = {});

/// Accepts every text that is not empty. `what` describes the text: "a file's name", "HOST:PORT".
CLI::Validator some(std::string what);

/// Accepts every file name, whether the file exists or not.
CLI::Validator file_name();
/// Accepts a file that can be written now: its folder exists, and neither is write-protected.
/// Checking early avoids losing the result of a long computation.
CLI::Validator writable_file();
/// Like writable_file(), but for a file that is written under a temporary name and then renamed.
/// The file's folder must be writable, too.
CLI::Validator replaceable_file();
CLI::Validator existing_file();
CLI::Validator existing_folder();

template <std::integral Number>
CLI::Validator whole_number(Number least, Number most) {
  return must_be(
      fmt::format("a whole number from {} to {}", least, most),
      [=](const std::string& text) {
        Number number{};
        // Accept only digits. CLI11 takes 010 for octal and wraps numbers that are too large.
        std::from_chars(text.data(), text.data() + text.size(), number);
        return text == std::to_string(number) && number >= least && number <= most;
      },
      fmt::format("[{} to {}]", least, most));
}

/// Accepts a decimal number. Infinities and NaN are never allowed.
CLI::Validator number(double least, double most);
CLI::Validator number_above_zero(double most);

/// For Option::check(): accepts one of `words`.
CLI::Validator one_of(std::vector<std::string> words);

/// For Option::transform(): replaces a word by its value.
template <class Value>
requires std::is_enum_v<Value> CLI::Validator one_of(std::vector<std::pair<std::string, Value>> values) {
  std::vector<std::string> words;
  words.reserve(values.size());
  for (const auto& [word, value] : values) words.push_back(word);
  const CLI::Validator is_one = one_of(std::move(words));
  return {[values = std::move(values), is_one](std::string& text) {
            std::string wrong = is_one(std::as_const(text));
            if (!wrong.empty()) return wrong;
            const auto found =
                std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == text; });
            text = std::to_string(static_cast<std::underlying_type_t<Value>>(found->second));
            return std::string();
          },
          ""};
}

/// Smallest and largest allowed width and height, in pixels.
struct PixelLimits {
  int least = 16, most = 8192;
};
/// Adds an option that takes WIDTHxHEIGHT in pixels, both even and within `limits`.
CLI::Option* add_size(CLI::App& app, const std::string& flag, int& width, int& height, PixelLimits limits,
                      const std::string& description);

/// Adds an option that takes NEAR:FAR in metres, from 0.05 to 65.
CLI::Option* add_depth_range(CLI::App& app, const std::string& flag, DepthRange& range,
                             const std::string& description);

}  // namespace copresence::command_line
