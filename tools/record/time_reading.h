#pragma once

// Interprets numbers in lists and file names as times. The unit is recognised from their size and
// their steps.
//
// Thread: free functions; concurrent calls are safe.

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::record {

enum class TimeUnit { kSeconds, kMilliseconds, kMicroseconds, kNanoseconds, kFrames };

/// "seconds", "milliseconds", ..., "frame numbers".
const char* name(TimeUnit unit);

/// A number in a list or a file name.
struct TimeNumber {
  long double value = 0;     ///< Exact for nanoseconds since 1970 on x86-64.
  bool has_point = false;    ///< Written with a decimal point, so it is not a frame number.
  bool zero_padded = false;  ///< Such as "000012", which suggests a frame number.
};

/// Returns nothing if the text is not a finite decimal number.
std::optional<TimeNumber> parse_number(std::string_view text);

/// The interpretation of numbers.
struct TimeScale {
  TimeUnit unit = TimeUnit::kSeconds;
  bool since_1970 = false;  ///< Unix time, so the wall-clock time of the start is known
};

/// Recognises the unit of the numbers of one stream. These rules are tried in order:
///   1. the unit in which all numbers are dates from 2000 to 2100
///   2. whole numbers with steps of 1 to 4 are frame numbers
///   3. the only unit that gives 4 to 200 images per second
///   4. the only unit that gives 0.1 to 300 images per second
/// `frames_per_second` converts frame numbers.
/// Fails  kInvalid if several units or none are possible. The message lists the possible
///        interpretations and names --times.
Result<TimeScale> recognise_times(std::span<const TimeNumber> numbers, double frames_per_second);

/// The interpretation in a given unit. Only TimeScale::since_1970 is recognised.
TimeScale given_times(std::span<const TimeNumber> numbers, TimeUnit unit);

/// Fails  kInvalid for a time of more than a thousand years before or after zero.
Result<std::chrono::microseconds> to_time(const TimeNumber& number, TimeUnit unit, double frames_per_second);

/// Finds a date with a time of day in a file name, such as "2022-04-15_10-20-30.123" or
/// "20220415T102030". Returns seconds since 1970 in UTC, or nothing.
std::optional<TimeNumber> find_date(std::string_view text);

/// Formats a time as "2022-04-15 05:20:00.033 UTC". Requires a time within 3,000 years of 1970.
std::string utc_text(std::chrono::microseconds since_1970);

}  // namespace copresence::record
