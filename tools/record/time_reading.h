#pragma once

// Interprets numbers in lists and file names as times. The size and steps of the numbers reveal the
// unit. Thread: free functions; concurrent calls are safe.

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace copresence::record {

enum class TimeUnit { kSeconds, kMilliseconds, kMicroseconds, kNanoseconds, kFrames };

/// Such as "seconds", "milliseconds" or "frame numbers".
const char* name(TimeUnit unit);

/// A number in a list or a file name.
struct TimeNumber {
  long double value = 0;     ///< Exact for nanoseconds since 1970 on x86-64.
  bool has_point = false;    ///< True for numbers with a decimal point, unlike frame numbers.
  bool zero_padded = false;  ///< True for numbers such as "000012", which suggest a frame number.
};

/// Returns nothing if the text is not a finite decimal number.
std::optional<TimeNumber> parse_number(std::string_view text);

/// The interpretation of the numbers of one stream.
struct TimeScale {
  TimeUnit unit = TimeUnit::kSeconds;
  bool since_1970 = false;  ///< True for Unix time: the clock time of the start is known.
};

/// Recognises the unit of the numbers of one stream by the first rule that applies:
///   1. If all numbers are dates from 2000 to 2100 in one unit, that unit is right.
///   2. Whole numbers with steps of 1 to 4 are frame numbers.
///   3. If only one unit gives 4 to 200 images per second, that unit is right.
///   4. If only one unit gives 0.1 to 300 images per second, that unit is right.
/// `frames_per_second` converts frame numbers.
/// Fails with kInvalid if several units or none are possible. The message lists the possible
/// interpretations and names the option --times.
Result<TimeScale> recognise_times(std::span<const TimeNumber> numbers, double frames_per_second);

/// Interprets numbers in a given unit. Recognises only TimeScale::since_1970.
TimeScale given_times(std::span<const TimeNumber> numbers, TimeUnit unit);

/// Fails with kInvalid for a time of more than a thousand years before or after zero.
Result<std::chrono::microseconds> to_time(const TimeNumber& number, TimeUnit unit, double frames_per_second);

/// Finds a date with a time of day in a file name, such as "2022-04-15_10-20-30.123" or
/// "20220415T102030". Returns seconds since 1970 in UTC, or nothing.
std::optional<TimeNumber> find_date(std::string_view text);

/// Formats a time as "2022-04-15 05:20:00.033 UTC". Requires a time within 3,000 years of 1970.
std::string utc_text(std::chrono::microseconds since_1970);

}  // namespace copresence::record
