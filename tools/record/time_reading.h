#pragma once

// What numbers in lists and file names mean as times: their unit is recognised from their size and their steps.
//
// Thread: free functions on values, safe anywhere.

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

/// A number as it stands in a list or a file's name.
struct TimeNumber {
  long double value = 0;     ///< keeps nanoseconds since 1970 exactly on x86-64
  bool has_point = false;    ///< written with a decimal point, so no frame's number
  bool zero_padded = false;  ///< "000012", as frames' numbers are written
};

/// Nothing where the text is not a finite decimal number.
std::optional<TimeNumber> parse_number(std::string_view text);

/// What numbers are taken for.
struct TimeScale {
  TimeUnit unit = TimeUnit::kSeconds;
  bool since_1970 = false;  ///< they are Unix time, so the recording's start by the clock is known
};

/// The unit of the numbers of one stream. It is decided by, in this order: dates from 2000 to 2100 in one of the units;
/// steps of 1 to 4 between whole numbers, which are frames; the only unit in which the images come 4 to 200 times a
/// second; the only unit in which they come 0.1 to 300 times a second. `frames_per_second` is that of frame numbers.
/// Fails (kInvalid) where two units are possible or none is: the sentence shows every reading, and --times decides.
Result<TimeScale> recognise_times(std::span<const TimeNumber> numbers, double frames_per_second);

/// The same where the unit is given: only whether the numbers are Unix time is found out.
TimeScale given_times(std::span<const TimeNumber> numbers, TimeUnit unit);

/// Fails (kInvalid) for a number that lies more than a thousand years from zero.
Result<std::chrono::microseconds> to_time(const TimeNumber& number, TimeUnit unit, double frames_per_second);

/// A date with a time of day in a file's name ("2022-04-15_10-20-30.123", "20220415T102030"), read as UTC: seconds
/// since 1970. Nothing where there is none.
std::optional<TimeNumber> find_date(std::string_view text);

/// "2022-04-15 05:20:00.033 UTC". Requires a time within 3,000 years of 1970.
std::string utc_text(std::chrono::microseconds since_1970);

}  // namespace copresence::record
