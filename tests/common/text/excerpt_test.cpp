#include "common/text/excerpt.h"

#include <gtest/gtest.h>

namespace copresence::text {
namespace {

TEST(Excerpt, LeavesShortTextsAlone) {
  EXPECT_EQ(excerpt("left camera"), "left camera");
  EXPECT_EQ(excerpt(""), "");
  EXPECT_EQ(excerpt("1234", 4), "1234");
}

TEST(Excerpt, CutsLongOnesAndSaysHowLongTheyAre) {
  EXPECT_EQ(excerpt("12345", 4), "1234... (5 bytes)");
  EXPECT_LT(excerpt(std::string(5'000'000, 'a')).size(), 110u);
}

TEST(Excerpt, CutsBetweenCharacters) {
  EXPECT_EQ(excerpt("aaa\u00e4\u00e4", 4), "aaa... (7 bytes)");
  EXPECT_EQ(excerpt(std::string(9, '\x80'), 4), "... (9 bytes)");
}

TEST(Excerpt, LetsNothingThroughThatATerminalObeys) {
  EXPECT_EQ(excerpt("a\x1b[2J\nb"), "a?[2J?b");
}

}  // namespace
}  // namespace copresence::text
