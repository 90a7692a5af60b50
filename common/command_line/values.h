#pragma once

// What values of options may be. Each is looked at as the text that was given, before anything is made of it, so that a wrong one is
// refused with one sentence that names the option, what was given and what is allowed:
//
//   capture_server: --depth-qp: "foo" is not a whole number from 0 to 51; see --help
//
// Thread: pure; what is returned is used while a command line is parsed.

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

/// For Option::check(): a text for which `is_one` holds; else `"TEXT" is not WHAT`. `in_help` follows the option's type.
CLI::Validator must_be(std::string what, std::function<bool(const std::string&)> is_one,
                       std::string in_help = {});

/// Any text but an empty one, which is `what`: "a file's name", "HOST:PORT".
CLI::Validator some(std::string what);

/// A file's name; whether it is there or can be written is found out later.
CLI::Validator file_name();
/// A file that can be written as things stand: its folder is there, and neither is protected. So what takes minutes to
/// make does not end at the last step.
CLI::Validator writable_file();
/// The same for one that is made beside its name first and then moved there, so that its folder must be writable, too.
CLI::Validator replaceable_file();
CLI::Validator existing_file();
CLI::Validator existing_folder();

template <std::integral Number>
CLI::Validator whole_number(Number least, Number most) {
  return must_be(
      fmt::format("a whole number from {} to {}", least, most),
      [=](const std::string& text) {
        Number number{};
        // Digits alone: to CLI11 010 is octal, and what overflows is something else.
        std::from_chars(text.data(), text.data() + text.size(), number);
        return text == std::to_string(number) && number >= least && number <= most;
      },
      fmt::format("[{} to {}]", least, most));
}

/// Infinities and what is no number are never allowed.
CLI::Validator number(double least, double most);
CLI::Validator number_above_zero(double most);

/// For Option::check().
CLI::Validator one_of(std::vector<std::string> words);

/// For Option::transform(): the value that a word stands for.
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

/// An option that takes WIDTHxHEIGHT in pixels, both even and within these.
struct PixelLimits {
  int least = 16, most = 8192;
};
CLI::Option* add_size(CLI::App& app, const std::string& flag, int& width, int& height, PixelLimits limits,
                      const std::string& description);

/// An option that takes NEAR:FAR in metres, 0.05 to 65.
CLI::Option* add_depth_range(CLI::App& app, const std::string& flag, DepthRange& range,
                             const std::string& description);

}  // namespace copresence::command_line
