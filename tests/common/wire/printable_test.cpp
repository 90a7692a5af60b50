#include "common/wire/printable.h"

#include <gtest/gtest.h>

namespace copresence::wire {
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
  EXPECT_EQ(made_printable("a\u202e\u2028", 100), "a??????");
  EXPECT_TRUE(is_printable("\u200d\u2013\u2027")) << "neighbours";
}

TEST(Printable, IsNoBrokenUtf8) {
  for (const char* text :
       {"\x80", "\xc3", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xff", "\xe5\x8f"}) {
    EXPECT_FALSE(is_printable(text));
  }
}

TEST(Printable, CanBeMadeOfAnything) {
  EXPECT_EQ(made_printable("a\tb\xff"
                           "c",
                           100),
            "a?b?c");
  EXPECT_EQ(made_printable("Küche", 2), "K") << "never half a character";
  EXPECT_EQ(made_printable("Küche", 3), "Kü");
  EXPECT_EQ(made_printable("x", 0), "");
}

}  // namespace
}  // namespace copresence::wire
