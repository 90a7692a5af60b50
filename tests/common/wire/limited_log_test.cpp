#include "common/wire/limited_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/text/excerpt.h"

namespace copresence::wire {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using Topic = LimitedLog::Topic;
using Severity = LimitedLog::Severity;

Instant at(int ms) {
  return Instant(milliseconds(1'000'000 + ms));
}

class LimitedLogTest : public ::testing::Test {
 protected:
  void say(const std::string& text, int ms, Topic topic = Topic::kNotice) {
    log_.say(topic, Severity::kWarning, text, at(ms));
  }
  std::vector<std::string> lines_;
  LimitedLog log_{[this](Severity, const std::string& line) { lines_.push_back(line); }};
};

TEST_F(LimitedLogTest, SaysAFewLinesAtOnce) {
  say("unplugged", 0);
  say("back", 100);
  say("unplugged", 200);
  EXPECT_THAT(lines_, ElementsAre("unplugged", "back", "unplugged"));
}

TEST_F(LimitedLogTest, CountsTheSameLineAndSaysItAgainLater) {
  for (int i = 0; i < 40'000; ++i) say("unplugged", i / 4);
  EXPECT_THAT(lines_, ElementsAre("unplugged"));
  log_.catch_up(at(9'999));
  EXPECT_EQ(lines_.size(), 1u);
  log_.catch_up(at(10'000));
  EXPECT_THAT(lines_, ElementsAre("unplugged", "unplugged (39998 more like this)"));
  log_.catch_up(at(60'000));
  EXPECT_EQ(lines_.size(), 2u);
}

TEST_F(LimitedLogTest, HoldsBackDifferentLinesTooWhereThereAreMany) {
  for (int ms = 0; ms < 60'000; ++ms) say("line " + std::to_string(ms), ms);
  EXPECT_LE(lines_.size(), 4u + 6u);
  EXPECT_THAT(lines_.back(), testing::HasSubstr("more like this"));
}

TEST_F(LimitedLogTest, LosesNoCount) {
  for (int ms = 0; ms < 60'000; ++ms) say("line " + std::to_string(ms), ms);
  log_.finish();
  std::uint64_t said = lines_.size();
  for (const std::string& line : lines_) {
    if (const auto at = line.find('('); at != std::string::npos) said += std::stoull(line.substr(at + 1));
  }
  EXPECT_EQ(said, 60'000u);
}

TEST_F(LimitedLogTest, AFloodOfOneTopicHidesNoOther) {
  for (int i = 0; i < 1000; ++i) say("notice " + std::to_string(i), 0);
  const std::size_t before = lines_.size();
  say("the server hung up", 0, Topic::kConnection);
  ASSERT_EQ(lines_.size(), before + 1);
  EXPECT_EQ(lines_.back(), "the server hung up");
}

TEST_F(LimitedLogTest, BoundsAndCleansEveryLine) {
  say(std::string(100'000, 'x'), 0);
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_EQ(lines_[0].size(), LimitedLog::kMostBytes + 3);
  say("red \x1b[31m, bell \a, line\nfeed, \xff, turned \xe2\x80\xae over", 1);
  EXPECT_TRUE(text::is_printable(lines_[1])) << lines_[1];
}

}  // namespace
}  // namespace copresence::wire
