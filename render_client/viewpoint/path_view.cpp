#include "render_client/viewpoint/path_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>

#include "render_client/viewpoint/look_at.h"

namespace copresence::viewpoint {
namespace {

constexpr std::string_view kBlank = " \t\r\v\f";
constexpr double kFarthest = 1e6;  // metres; beyond it there is no room to look into, only a typing error

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

Result<PathView> PathView::load(const std::filesystem::path& path, const Eigen::Vector3d& up) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return fail(ErrorCode::kNotFound,
                fmt::format("cannot read the path file {}: it is a folder", path.string()));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return fail(ErrorCode::kNotFound, fmt::format("cannot read the path file {}: {}", path.string(),
                                                  std::generic_category().message(errno)));
  }
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return parse(text, path.string(), up);
}

Result<PathView> PathView::parse(std::string_view text, std::string_view name, const Eigen::Vector3d& up) {
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
    if (!view) return refuse(fmt::format("'{}' is no view index", words[0]));
    if (!stops.empty() && *view <= stops.back().view) {
      return refuse(fmt::format("view {} comes after view {}: indices must rise", *view, stops.back().view));
    }
    double metres[6];
    for (std::size_t i = 0; i < 6; ++i) {
      const auto value = number<double>(words[i + 1]);
      if (!value || !(std::abs(*value) <= kFarthest)) {
        return refuse(fmt::format("'{}' is no coordinate in metres", words[i + 1]));
      }
      metres[i] = *value;
    }
    stops.push_back({*view, {metres[0], metres[1], metres[2]}, {metres[3], metres[4], metres[5]}});
    if (stops.back().eye == stops.back().look) return refuse("the eye looks at the point where it stands");
  }
  if (stops.empty()) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("{}: no line says where the eye stands; write view x y z look_x look_y look_z", name));
  }
  return PathView(std::move(stops), up);
}

Eye PathView::at(std::uint64_t view_index, Instant) {
  const auto after = std::upper_bound(stops_.begin(), stops_.end(), view_index,
                                      [](std::uint64_t view, const Stop& stop) { return view < stop.view; });
  if (after == stops_.begin()) return {look_at(stops_.front().eye, stops_.front().look, up_)};
  const Stop& from = *std::prev(after);
  if (after == stops_.end()) return {look_at(from.eye, from.look, up_)};
  const double share =
      static_cast<double>(view_index - from.view) / static_cast<double>(after->view - from.view);
  return {look_at(from.eye + share * (after->eye - from.eye), from.look + share * (after->look - from.look),
                  up_)};
}

}  // namespace copresence::viewpoint
