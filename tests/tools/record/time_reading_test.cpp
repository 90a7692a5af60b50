#include "tools/record/time_reading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace copresence::record {
namespace {

using std::chrono::microseconds;
using testing::HasSubstr;

std::vector<TimeNumber> numbers(const std::string& text) {
  std::istringstream words(text);
  std::vector<TimeNumber> numbers;
  for (std::string word; words >> word;) numbers.push_back(*parse_number(word));
  return numbers;
}

Result<TimeScale> recognise(const std::string& text) {
  return recognise_times(numbers(text), 30);
}

TEST(TimeReading, RecognisesUnixTimeInEveryUnit) {
  const std::pair<const char*, TimeUnit> sets[] = {
      {"1305031102.160407 1305031102.194330 1305031102.226738", TimeUnit::kSeconds},
      {"1650000000 1650000001 1650000002", TimeUnit::kSeconds},
      {"1650000000000 1650000000033 1650000000066", TimeUnit::kMilliseconds},
      {"1582018310593.05 1582018310626.41 1582018310659.77", TimeUnit::kMilliseconds},
      {"1650000000000000 1650000000033333 1650000000066666", TimeUnit::kMicroseconds},
      {"1650000000000000000 1650000000033333333 1650000000066666666", TimeUnit::kNanoseconds}};
  for (const auto& [text, unit] : sets) {
    const auto scale = recognise(text);
    ASSERT_TRUE(scale) << scale.error().what;
    EXPECT_EQ(scale->unit, unit) << text;
    EXPECT_TRUE(scale->since_1970) << text;
  }
}

TEST(TimeReading, RecognisesTimesFromAZeroOfTheirOwnByTheirSteps) {
  const std::pair<const char*, TimeUnit> sets[] = {
      {"0.000 0.033 0.067 0.100", TimeUnit::kSeconds},
      {"0 33 66 100 133", TimeUnit::kMilliseconds},
      {"0.0 33.3 66.7 100.0", TimeUnit::kMilliseconds},
      {"0 33369 66738 100107", TimeUnit::kMicroseconds},
      {"1300000000 1300033333 1300066666", TimeUnit::kMicroseconds},  // a device's clock, no date
      {"0 33333333 66666666", TimeUnit::kNanoseconds},
      {"1 2 3 4", TimeUnit::kFrames},
      {"0 2 4 8", TimeUnit::kFrames},
      {"000010 000020 000030", TimeUnit::kFrames},
      {"7", TimeUnit::kFrames}};
  for (const auto& [text, unit] : sets) {
    const auto scale = recognise(text);
    ASSERT_TRUE(scale) << text << ": " << scale.error().what;
    EXPECT_EQ(scale->unit, unit) << text;
    EXPECT_FALSE(scale->since_1970) << text;
  }
}

TEST(TimeReading, ShowsBothReadingsWhereTwoArePossible) {
  const auto tens = recognise("0 10 20 30");
  ASSERT_FALSE(tens);
  EXPECT_THAT(tens.error().what,
              testing::AllOf(HasSubstr("as ms: 0.03 s at 100 frames/s"),
                             HasSubstr("as frame: 1 s at 3 frames/s"), HasSubstr("--times")));
  EXPECT_THAT(recognise("1650000000 1650000020 1650000040").error().what,
              testing::AllOf(HasSubstr("as s: 40 s"), HasSubstr("as ms: 0.04 s")));
  EXPECT_THAT(recognise("0.25 20.25 40.25").error().what,
              testing::AllOf(HasSubstr("as s"), HasSubstr("as ms")));
}

TEST(TimeReading, ConvertsWithoutLosingMicroseconds) {
  EXPECT_EQ(*to_time(*parse_number("1650000000033333333"), TimeUnit::kNanoseconds, 30),
            microseconds(1650000000033333));
  EXPECT_EQ(*to_time(*parse_number("1305031102.160407"), TimeUnit::kSeconds, 30),
            microseconds(1305031102160407));
  EXPECT_EQ(*to_time(*parse_number("3"), TimeUnit::kFrames, 30), microseconds(100'000));
  EXPECT_FALSE(to_time(*parse_number("1e12"), TimeUnit::kSeconds, 30));
}

TEST(TimeReading, ReadsDatesInNames) {
  const char* names[] = {"2022-04-15_05-20-00.250", "20220415_052000_250", "2022-04-15T05:20:00.250Z",
                         "cam1_2022.04.15-05h20m00s250", "20220415052000250"};
  for (const char* name : names) {
    const auto date = find_date(name);
    ASSERT_TRUE(date) << name;
    EXPECT_NEAR(static_cast<double>(date->value), 1650000000.25, 1e-6) << name;
  }
  for (const char* name : {"000012", "1650000000000", "2022-04-15_000123", "2022-13-15_05-20-00"}) {
    EXPECT_FALSE(find_date(name)) << name;
  }
  EXPECT_EQ(utc_text(microseconds(1650000000250000)), "2022-04-15 05:20:00.250 UTC");
}

TEST(TimeReading, TakesOnlyPlainNumbers) {
  for (const char* text : {"", "nan", "inf", "0x10", "1,5", "12a"}) EXPECT_FALSE(parse_number(text)) << text;
  EXPECT_TRUE(parse_number("1.305031102e+09"));
}

}  // namespace
}  // namespace copresence::record
