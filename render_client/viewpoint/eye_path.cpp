#include "render_client/viewpoint/eye_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>

#include "common/text/excerpt.h"
#include "common/text/text_file.h"

namespace copresence::viewpoint {
namespace {

constexpr std::string_view kBlank = " \t\r\v\f";
constexpr std::size_t kMostBytes = 16 << 20;  // Enough for an hour with one line per view.
constexpr std::size_t kMostOfAWord = 40;
constexpr double kFarthest = 1e6;  // Metres. Greater values are typing errors.

std::vector<std::string_view> words_of(std::string_view line) {
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBlank); at != line.npos;
       at = line.find_first_not_of(kBlank, at)) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

template <class Number>
std::optional<Number> number(std::string_view word) {
  Number value{};
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

Result<EyePath> EyePath::load(const std::filesystem::path& path) {
  const auto text = text::read_text_file(path, "a path file", kMostBytes);
  if (!text) return fail(text.error());
  return parse(*text, path.string());
}

Result<EyePath> EyePath::parse(std::string_view text, std::string_view name) {
  std::vector<Stop> stops;
  int line_number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const auto words = words_of(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line_number;
    if (words.empty()) continue;
    const auto refuse = [&](const std::string& what) {
      return fail(ErrorCode::kInvalid, fmt::format("{}:{}: {}", name, line_number, what));
    };
    if (words.size() != 7) {
      return refuse(
          fmt::format("{} words where seven are expected: view x y z look_x look_y look_z", words.size()));
    }
    const auto view = number<std::uint64_t>(words[0]);
    if (!view) return refuse(fmt::format("'{}' is no view index", text::excerpt(words[0], kMostOfAWord)));
    if (!stops.empty() && *view <= stops.back().view) {
      return refuse(fmt::format("view {} comes after view {}: indices must rise", *view, stops.back().view));
    }
    double metres[6];
    for (std::size_t i = 0; i < 6; ++i) {
      const auto value = number<double>(words[i + 1]);
      if (!value || !(std::abs(*value) <= kFarthest)) {
        return refuse(
            fmt::format("'{}' is no coordinate in metres", text::excerpt(words[i + 1], kMostOfAWord)));
      }
      metres[i] = *value;
    }
    const Place place{{metres[0], metres[1], metres[2]}, {metres[3], metres[4], metres[5]}};
    if (place.eye == place.look) return refuse("the eye looks at the point where it stands");
    stops.push_back({*view, place});
  }
  if (stops.empty()) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: no line says where the eye stands; write view x y z look_x look_y look_z", name));
  }
  return EyePath(std::move(stops));
}

EyePath::Place EyePath::at(std::uint64_t view) const {
  const auto after =
      std::upper_bound(stops_.begin(), stops_.end(), view,
                       [](std::uint64_t wanted, const Stop& stop) { return wanted < stop.view; });
  if (after == stops_.begin()) return stops_.front().place;
  const Stop& from = *std::prev(after);
  if (after == stops_.end()) return from.place;
  const double share = static_cast<double>(view - from.view) / static_cast<double>(after->view - from.view);
  return {from.place.eye + share * (after->place.eye - from.place.eye),
          from.place.look + share * (after->place.look - from.place.look)};
}

}  // namespace copresence::viewpoint
