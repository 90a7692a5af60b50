#include "common/command_line/values.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include "common/text/excerpt.h"

namespace copresence::command_line {
namespace {

constexpr std::size_t kMostOfAValue = 300;

template <class Number>
std::optional<Number> parse(const std::string& text) {
  Number number{};
  if (!CLI::detail::lexical_cast(text, number)) return std::nullopt;
  return number;
}

/// Parses the numbers before and after the first `separator`. Returns nothing on failure.
template <class Number>
std::optional<std::pair<Number, Number>> parse_two(const std::string& text, char separator) {
  const auto at = text.find(separator);
  if (at == std::string::npos) return std::nullopt;
  const auto first = parse<Number>(text.substr(0, at)), second = parse<Number>(text.substr(at + 1));
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

/// Joins words for a sentence: "auto, gl or cpu".
std::string in_words(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

/// Adds an option whose text is checked. `take` converts the text after the check.
CLI::Option* add_checked(CLI::App& app, const std::string& flag, const std::string& description,
                         const CLI::Validator& check, const std::function<void(const std::string&)>& take) {
  return app.add_option_function<std::string>(flag, take, description)->check(check);
}

/// Returns the reason why a file cannot be written, or an empty text if it can be written.
std::string unwritable(const std::string& text, bool is_replaced) {
  namespace fs = std::filesystem;
  if (text.empty()) return "\"\" is not a file's name";
  std::error_code none;
  const fs::path file(text), folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::string why;
  if (!fs::is_directory(folder, none)) {
    why = fmt::format("there is no folder {}", folder.string());
  } else if (fs::is_directory(file, none)) {
    why = "it is a folder";
  } else if (fs::exists(file, none) && access(text.c_str(), W_OK) != 0) {
    why = "it is write-protected";
  } else if ((is_replaced || !fs::exists(file, none)) && access(folder.c_str(), W_OK) != 0) {
    why = fmt::format("you may not write in the folder {}", folder.string());
  }
  return why.empty() ? why
                     : fmt::format("\"{}\" is not a file that can be written: {}",
                                   text::excerpt(text, kMostOfAValue), text::excerpt(why, kMostOfAValue));
}

}  // namespace

CLI::Validator must_be(std::string what, std::function<bool(const std::string&)> is_one,
                       std::string in_help) {
  return {[what = std::move(what), is_one = std::move(is_one)](const std::string& text) {
            if (is_one(text)) return std::string();
            return fmt::format("\"{}\" is not {}", text::excerpt(text, kMostOfAValue), what);
          },
          std::move(in_help)};
}

CLI::Validator some(std::string what) {
  return must_be(std::move(what), [](const std::string& text) { return !text.empty(); });
}

CLI::Validator file_name() {
  return some("a file's name");
}

CLI::Validator writable_file() {
  return {[](const std::string& text) { return unwritable(text, false); }, ""};
}

CLI::Validator replaceable_file() {
  return {[](const std::string& text) { return unwritable(text, true); }, ""};
}

CLI::Validator existing_file() {
  return must_be("a file that is there", [](const std::string& text) {
    std::error_code none;
    return std::filesystem::exists(text, none) && !std::filesystem::is_directory(text, none);
  });
}

CLI::Validator existing_folder() {
  return must_be("a folder that is there", [](const std::string& text) {
    std::error_code none;
    return std::filesystem::is_directory(text, none);
  });
}

CLI::Validator number(double least, double most) {
  return must_be(
      fmt::format("a number from {:g} to {:g}", least, most),
      [=](const std::string& text) {
        const auto value = parse<double>(text);
        return value && std::isfinite(*value) && *value >= least && *value <= most;
      },
      fmt::format("[{:g} to {:g}]", least, most));
}

CLI::Validator number_above_zero(double most) {
  return must_be(
      fmt::format("a number above 0, at most {:g}", most),
      [=](const std::string& text) {
        const auto value = parse<double>(text);
        return value && std::isfinite(*value) && *value > 0 && *value <= most;
      },
      fmt::format("[above 0, to {:g}]", most));
}

CLI::Validator one_of(std::vector<std::string> words) {
  std::string what = in_words(words);
  return must_be(std::move(what), [words = std::move(words)](const std::string& text) {
    return std::find(words.begin(), words.end(), text) != words.end();
  });
}

CLI::Option* add_size(CLI::App& app, const std::string& flag, int& width, int& height, PixelLimits limits,
                      const std::string& description) {
  const auto is_size = [limits](const std::string& text) {
    const auto fits = [&](int side) { return side >= limits.least && side <= limits.most && side % 2 == 0; };
    const auto size = parse_two<int>(text, 'x');
    return size && fits(size->first) && fits(size->second);
  };
  return add_checked(app, flag, description,
                     must_be(fmt::format("WIDTHxHEIGHT in pixels, such as {}x{}, both even and from {} to {}",
                                         width, height, limits.least, limits.most),
                             is_size),
                     [&width, &height](const std::string& text) {
                       std::tie(width, height) = *parse_two<int>(text, 'x');
                     })
      ->default_str(fmt::format("{}x{}", width, height));
}

CLI::Option* add_depth_range(CLI::App& app, const std::string& flag, DepthRange& range,
                             const std::string& description) {
  constexpr double kNearest = 0.05, kFarthest = 65;
  const auto is_range = [](const std::string& text) {
    const auto metres = parse_two<double>(text, ':');
    return metres && metres->first >= kNearest && metres->first < metres->second &&
           metres->second <= kFarthest;
  };
  return add_checked(app, flag, description,
                     must_be(fmt::format("NEAR:FAR in metres, such as 0.4:5, with NEAR at least {:g} and "
                                         "below FAR, FAR at most {:g}",
                                         kNearest, kFarthest),
                             is_range),
                     [&range](const std::string& text) {
                       const auto metres = *parse_two<double>(text, ':');
                       range = {metres.first, metres.second};
                     })
      ->default_str(fmt::format("{:g}:{:g}", range.near_m, range.far_m));
}

}  // namespace copresence::command_line
