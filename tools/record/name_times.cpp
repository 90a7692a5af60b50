#include "tools/record/name_times.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <string>

namespace copresence::record {
namespace {

namespace fs = std::filesystem;

using Column = std::vector<TimeNumber>;

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Returns the numbers in a file name. "1305031102.175304" and "Depth_1582018310593.059" contain a
// number with a decimal point, "frame-000012.color" does not.
std::vector<std::string> numbers_in(const std::string& stem) {
  constexpr std::size_t kDigitsOfATime = 6;
  const bool is_one_number = stem.find_first_not_of("0123456789.") == std::string::npos;
  std::vector<std::string> numbers;
  for (std::size_t at = 0; at < stem.size();) {
    if (!is_digit(stem[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < stem.size() && is_digit(stem[end])) ++end;
    const bool has_fraction = end + 1 < stem.size() && stem[end] == '.' && is_digit(stem[end + 1]);
    if (has_fraction && (is_one_number || end - at >= kDigitsOfATime)) {
      for (++end; end < stem.size() && is_digit(stem[end]);) ++end;
    }
    numbers.push_back(stem.substr(at, end - at));
    at = end;
  }
  return numbers;
}

// Collects the numbers of all names by their position in the name. If names contain different
// counts of numbers, uses only the last number of each.
std::vector<std::vector<std::string>> columns_of(const std::vector<fs::path>& paths) {
  std::vector<std::vector<std::string>> rows;
  bool are_alike = true;
  for (const fs::path& path : paths) {
    rows.push_back(numbers_in(path.stem().string()));
    are_alike = are_alike && rows.back().size() == rows.front().size();
    if (rows.back().empty()) return {};
  }
  const std::size_t count = are_alike && !rows.empty() ? rows.front().size() : 1;
  std::vector<std::vector<std::string>> columns(count);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < count; ++i) columns[i].push_back(row[row.size() - count + i]);
  }
  return columns;
}

Column parsed(const std::vector<std::string>& texts) {
  Column column;
  for (const std::string& text : texts) column.push_back(parse_number(text).value_or(TimeNumber{}));
  return column;
}

bool varies(const Column& column) {
  return std::any_of(column.begin(), column.end(),
                     [&](const TimeNumber& number) { return number.value != column.front().value; });
}

// Reads names such as "1305031102-175304000": Unix seconds and their fraction in ms, us or ns.
std::optional<Column> seconds_and_fraction(const std::vector<std::string>& seconds,
                                           const std::vector<std::string>& fractions) {
  Column column = parsed(seconds);
  if (!given_times(column, TimeUnit::kSeconds).since_1970) return std::nullopt;
  const std::size_t digits = fractions.front().size();
  if (digits != 3 && digits != 6 && digits != 9) return std::nullopt;
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (fractions[i].size() != digits || seconds[i].find('.') != std::string::npos) return std::nullopt;
    const auto whole = parse_number(seconds[i] + '.' + fractions[i]);
    if (!whole) return std::nullopt;
    column[i] = *whole;
  }
  return column;
}

NamedTimes with_times(const std::vector<fs::path>& paths, const Column& column, TimeScale scale) {
  NamedTimes named;
  named.scale = scale;
  for (std::size_t i = 0; i < paths.size(); ++i) named.images.push_back({column[i], paths[i]});
  return named;
}

// Returns the dates in the names if all names have one and the steps are plausible for a recording.
std::optional<Column> dates_of(const std::vector<fs::path>& paths, double frames_per_second) {
  Column column;
  for (const fs::path& path : paths) {
    const auto date = find_date(path.stem().string());
    if (!date) return std::nullopt;
    column.push_back(*date);
  }
  const auto scale = recognise_times(column, frames_per_second);
  if (!scale || scale->unit != TimeUnit::kSeconds) return std::nullopt;
  std::set<long double> distinct;
  for (const TimeNumber& number : column) distinct.insert(number.value);
  if (column.size() > 1) {
    const long double span = *distinct.rbegin() - *distinct.begin();
    if (span < static_cast<long double>(column.size()) * 1e-3L)
      return std::nullopt;  // The dates are equal, so another number counts frames.
  }
  return column;
}

}  // namespace

Result<NamedTimes> times_of_names(const std::vector<fs::path>& paths, std::optional<TimeUnit> unit,
                                  double frames_per_second) {
  if (!unit || *unit == TimeUnit::kSeconds) {
    if (const auto dates = dates_of(paths, frames_per_second)) {
      return with_times(paths, *dates, {TimeUnit::kSeconds, true});
    }
  }
  const auto texts = columns_of(paths);
  std::vector<Column> columns;
  if (!unit || *unit == TimeUnit::kSeconds) {
    for (std::size_t i = 0; i + 1 < texts.size(); ++i) {
      if (const auto both = seconds_and_fraction(texts[i], texts[i + 1])) {
        return with_times(paths, *both, {TimeUnit::kSeconds, true});
      }
    }
  }
  for (const auto& column : texts) {
    columns.push_back(parsed(column));
    if (columns.size() > 1 && !varies(columns.back()) && paths.size() > 1) columns.pop_back();
  }
  if (columns.size() > 1 && !varies(columns.front()) && paths.size() > 1) columns.erase(columns.begin());
  const bool none_varies = columns.empty() || (paths.size() > 1 && !varies(columns.back()));
  if (none_varies) {
    Column positions;
    for (std::size_t i = 0; i < paths.size(); ++i)
      positions.push_back({static_cast<long double>(i), false, false});
    return with_times(paths, positions, {TimeUnit::kFrames, false});
  }
  std::optional<std::size_t> counts;  // The last column with frame numbers.
  std::optional<Error> undecided;
  for (std::size_t i = columns.size(); i-- > 0;) {
    const auto scale = recognise_times(columns[i], frames_per_second);
    if (!scale) {
      if (!undecided) undecided = scale.error();
    } else if (scale->unit == TimeUnit::kFrames) {
      if (!counts) counts = i;
    } else if (!unit || *unit == scale->unit) {
      return with_times(paths, columns[i], *scale);
    }
  }
  if (unit) {
    const std::size_t chosen = *unit == TimeUnit::kFrames && counts ? *counts : columns.size() - 1;
    return with_times(paths, columns[chosen], given_times(columns[chosen], *unit));
  }
  if (counts) return with_times(paths, columns[*counts], {TimeUnit::kFrames, false});
  return fail(std::move(*undecided));
}

}  // namespace copresence::record
