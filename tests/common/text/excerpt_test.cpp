#include "common/text/excerpt.h"

#include <gtest/gtest.h>

namespace copresence::text {
namespace {

TEST(Printable, IsWhatPeopleWrite) {
  for (const char* text : {"", "left", "Küche 2", "台所", "\U0001f3e0", "~ !"})
    EXPECT_TRUE(is_printable(text)) << text;
}

TEST(Printable, IsNothingThatMovesACursor) {
  for (const char* text : {"\n", "\x1b[2J", "\x7f", "\xc2\x9b"}) EXPECT_FALSE(is_printable(text)) << text;
  EXPECT_FALSE(is_printable(std::string_view("\0", 1)));
}

TEST(Printable, IsNothingThatTurnsOrSplitsALine) {
  for (const char* text : {"\u202e", "\u2066", "\u200f", "\u061c", "\u2028", "\u2029"}) {
    EXPECT_FALSE(is_printable(text)) << text;
  }
  EXPECT_EQ(sanitise("a\u202e\u2028", 100), "a??????");
  EXPECT_TRUE(is_printable("\u200d\u2013\u2027")) << "neighbours";
}

TEST(Printable, IsNoBrokenUtf8) {
  for (const char* text :
       {"\x80", "\xc3", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff", "\xe5\x8f"}) {
    EXPECT_FALSE(is_printable(text));
  }
}

TEST(Sanitise, MakesAnyBytesPrintable) {
  EXPECT_EQ(sanitise("a\tb\xff"
                     "c",
                     100),
            "a?b?c");
  EXPECT_EQ(sanitise("Küche", 2), "K") << "never half a character";
  EXPECT_EQ(sanitise("Küche", 3), "Kü");
  EXPECT_EQ(sanitise("x", 0), "");
}

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
  EXPECT_EQ(excerpt(std::string(9, '\x80'), 4), "????... (9 bytes)");
}

TEST(Excerpt, LetsNothingThroughThatATerminalObeys) {
  EXPECT_EQ(excerpt("a\x1b[2J\nb"), "a?[2J?b");
}

}  // namespace
}  // namespace copresence::text
