#include "tools/record/time_reading.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iterator>
#include <regex>

namespace copresence::record {
namespace {

using std::chrono::microseconds;

constexpr TimeUnit kTimes[] = {TimeUnit::kSeconds, TimeUnit::kMilliseconds, TimeUnit::kMicroseconds,
                               TimeUnit::kNanoseconds};

// The dates 2000-01-01 and 2100-01-01 in seconds since 1970.
constexpr long double kEarliestDate = 946'684'800, kLatestDate = 4'102'444'800;

// Frames per second: the usual range of cameras, and the possible range of recordings.
constexpr double kSlowVideo = 4, kFastVideo = 200, kSlowest = 0.1, kFastest = 300;
// Numbers with a longer step are not dates.
constexpr double kLongestStepS = 600;
constexpr long double kLargestFrameStep = 4;
// Time steps differ from their median by less than this share.
constexpr long double kJitter = 0.25;
constexpr long double kMostMicroseconds = 3.2e16L;  // Limit of a time: a thousand years.

long double per_second(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::kMilliseconds:
      return 1e3L;
    case TimeUnit::kMicroseconds:
      return 1e6L;
    case TimeUnit::kNanoseconds:
      return 1e9L;
    default:
      return 1;
  }
}

const char* short_name(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::kSeconds:
      return "s";
    case TimeUnit::kMilliseconds:
      return "ms";
    case TimeUnit::kMicroseconds:
      return "us";
    case TimeUnit::kNanoseconds:
      return "ns";
    case TimeUnit::kFrames:
      return "frame";
  }
  return "";
}

bool are_dates(std::span<const TimeNumber> numbers, TimeUnit unit) {
  return unit != TimeUnit::kFrames && std::all_of(numbers.begin(), numbers.end(), [&](const TimeNumber& n) {
           const long double seconds = n.value / per_second(unit);
           return seconds >= kEarliestDate && seconds < kLatestDate;
         });
}

bool is_plausible_rate(double rate) {
  return rate >= kSlowest && rate <= kFastest;
}

// The distinct numbers of one stream in ascending order, and their possible interpretations.
class Numbers {
 public:
  Numbers(std::span<const TimeNumber> numbers, double frames_per_second)
      : frames_per_second_(frames_per_second), all_(numbers) {
    for (const TimeNumber& number : numbers) {
      values_.push_back(number.value);
      whole_ = whole_ && !number.has_point;
      padded_ = padded_ || number.zero_padded;
    }
    std::sort(values_.begin(), values_.end());
    values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
    for (std::size_t i = 1; i < values_.size(); ++i) steps_.push_back(values_[i] - values_[i - 1]);
    std::vector<long double> sorted = steps_;
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty()) usual_step_ = sorted[(sorted.size() - 1) / 2];
  }

  Result<TimeScale> decide() const {
    const auto date = std::find_if(std::begin(kTimes), std::end(kTimes),
                                   [&](TimeUnit unit) { return are_dates(all_, unit); });
    bool is_dated = date != std::end(kTimes);
    if (steps_.empty()) {
      if (is_dated) return TimeScale{*date, true};
      return TimeScale{whole_ ? TimeUnit::kFrames : TimeUnit::kSeconds, false};
    }
    if (is_dated && (!whole_ || is_plausible_rate(rate(*date)))) return TimeScale{*date, true};
    if (is_dated && 1 / rate(*date) > kLongestStepS) is_dated = false;
    if (whole_ && usual_step_ <= kLargestFrameStep && !is_dated) return TimeScale{TimeUnit::kFrames, false};

    std::vector<TimeUnit> possible;
    if (is_dated) possible.push_back(*date);
    const auto video = std::find_if(std::begin(kTimes), std::end(kTimes), [&](TimeUnit unit) {
      return rate(unit) >= kSlowVideo && rate(unit) <= kFastVideo;
    });
    if (video != std::end(kTimes)) {
      possible.push_back(*video);
    } else {
      std::copy_if(std::begin(kTimes), std::end(kTimes), std::back_inserter(possible),
                   [&](TimeUnit unit) { return is_plausible_rate(rate(unit)); });
    }
    if (whole_ && !is_dated && rate(TimeUnit::kFrames) >= kSlowest && !steps_are_times()) {
      if (padded_) return TimeScale{TimeUnit::kFrames, false};
      possible.push_back(TimeUnit::kFrames);
    }
    // Numbers such as 0.25, 20.25, 40.25 may be seconds of a slow series, or milliseconds.
    if (!whole_ && video != std::end(kTimes) && *video != TimeUnit::kSeconds && steps_are_whole_and_equal()) {
      possible.insert(possible.begin(), TimeUnit::kSeconds);
    }
    if (possible.size() == 1) return TimeScale{possible.front(), is_dated};
    return ambiguous(possible);
  }

 private:
  double rate(TimeUnit unit) const {
    if (unit == TimeUnit::kFrames) return static_cast<double>(frames_per_second_ / usual_step_);
    return static_cast<double>(per_second(unit) / usual_step_);
  }

  double seconds(TimeUnit unit) const {
    const long double span = values_.back() - values_.front();
    return static_cast<double>(unit == TimeUnit::kFrames ? span / frames_per_second_
                                                         : span / per_second(unit));
  }

  // True for steps such as 33, 33, 34, which are rounded times of a camera. Steps of frame numbers
  // with lost frames are multiples of one number.
  bool steps_are_times() const {
    const bool multiples = std::all_of(steps_.begin(), steps_.end(),
                                       [&](long double step) { return std::fmod(step, usual_step_) == 0; });
    const auto near = std::count_if(steps_.begin(), steps_.end(), [&](long double step) {
      return std::abs(step - usual_step_) <= kJitter * usual_step_;
    });
    return !multiples && 10 * static_cast<std::size_t>(near) >= 6 * steps_.size();
  }

  bool steps_are_whole_and_equal() const {
    return std::all_of(steps_.begin(), steps_.end(), [&](long double step) {
      return std::abs(step - usual_step_) < 1e-6L && std::abs(step - std::round(step)) < 1e-6L;
    });
  }

  tl::unexpected<Error> ambiguous(std::vector<TimeUnit> units) const {
    const bool none = units.empty();
    if (none) {
      units.assign(std::begin(kTimes), std::end(kTimes));
      if (whole_) units.push_back(TimeUnit::kFrames);
    }
    std::string readings;
    for (const TimeUnit unit : units) {
      readings += fmt::format("{}as {}: {:.3g} s at {:.3g} frames/s", readings.empty() ? "" : "; ",
                              short_name(unit), seconds(unit), rate(unit));
    }
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the times from {} to {} {} ({}); give their unit with --times s, ms, us, ns or frame",
                    text(values_.front()), text(values_.back()),
                    none ? "fit no unit" : "can be read in more than one way", readings));
  }

  static std::string text(long double value) {
    return value == std::floor(value) ? fmt::format("{:.0f}", value) : fmt::format("{:.6f}", value);
  }

  long double frames_per_second_;
  std::span<const TimeNumber> all_;
  std::vector<long double> values_, steps_;
  long double usual_step_ = 0;
  bool whole_ = true, padded_ = false;
};

}  // namespace

const char* name(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::kSeconds:
      return "seconds";
    case TimeUnit::kMilliseconds:
      return "milliseconds";
    case TimeUnit::kMicroseconds:
      return "microseconds";
    case TimeUnit::kNanoseconds:
      return "nanoseconds";
    case TimeUnit::kFrames:
      return "frame numbers";
  }
  return "";
}

std::optional<TimeNumber> parse_number(std::string_view text) {
  const std::string copy(text);
  const bool decimal = !copy.empty() && copy.find_first_not_of("+-.0123456789eE") == std::string::npos;
  if (!decimal) return std::nullopt;
  char* end = nullptr;
  TimeNumber number;
  number.value = std::strtold(copy.c_str(), &end);
  if (*end != 0 || !std::isfinite(number.value)) return std::nullopt;
  number.has_point = copy.find('.') != std::string::npos;
  number.zero_padded = copy.size() > 1 && copy[0] == '0' && copy[1] != '.';
  return number;
}

Result<TimeScale> recognise_times(std::span<const TimeNumber> numbers, double frames_per_second) {
  return Numbers(numbers, frames_per_second).decide();
}

TimeScale given_times(std::span<const TimeNumber> numbers, TimeUnit unit) {
  return {unit, are_dates(numbers, unit)};
}

Result<microseconds> to_time(const TimeNumber& number, TimeUnit unit, double frames_per_second) {
  const long double us = unit == TimeUnit::kFrames ? number.value / frames_per_second * 1e6L
                                                   : number.value / per_second(unit) * 1e6L;
  if (!(std::abs(us) <= kMostMicroseconds)) {
    return fail(
        ErrorCode::kInvalid,
        fmt::format("the time {:g} in {} is more than a thousand years from zero; give its unit with --times "
                    "s, ms, us, ns or frame",
                    number.value, name(unit)));
  }
  return microseconds(std::llround(us));
}

std::optional<TimeNumber> find_date(std::string_view text) {
  static const std::regex kDate(
      R"((?:^|[^0-9])((?:19|20)\d\d)[-_.]?(0[1-9]|1[0-2])[-_.]?(0[1-9]|[12]\d|3[01])[-_ .T]*)"
      R"(([01]\d|2[0-3])[-_.:h]?([0-5]\d)[-_.:m]?([0-5]\d|60)(?:[-_.,:s]?(\d{1,9}))?(?:[^0-9]|$))");
  const std::string copy(text);
  std::smatch found;
  if (!std::regex_search(copy, found, kDate)) return std::nullopt;
  // In names such as 2022-04-15_000123, a frame number follows the date.
  const bool is_compact =
      found.position(5) == found.position(4) + 2 && found.position(6) == found.position(5) + 2;
  if (is_compact && !found[7].matched && found[4].str() == "00") return std::nullopt;
  std::tm date{};
  const auto number = [&](std::size_t i) { return std::stoi(found[i].str()); };
  date.tm_year = number(1) - 1900;
  date.tm_mon = number(2) - 1;
  date.tm_mday = number(3);
  date.tm_hour = number(4);
  date.tm_min = number(5);
  date.tm_sec = number(6);
  TimeNumber result;
  result.value = static_cast<long double>(::timegm(&date));
  result.has_point = true;
  if (found[7].matched) {
    const std::string digits = found[7].str();
    result.value += std::strtold(digits.c_str(), nullptr) / std::pow(10.0L, static_cast<int>(digits.size()));
  }
  return result;
}

std::string utc_text(microseconds since_1970) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(since_1970);
  const std::time_t time = seconds.count();
  std::tm date{};
  ::gmtime_r(&time, &date);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}.{:03} UTC", date.tm_year + 1900, date.tm_mon + 1,
                     date.tm_mday, date.tm_hour, date.tm_min, date.tm_sec,
                     (since_1970 - seconds).count() / 1000);
}

}  // namespace copresence::record
