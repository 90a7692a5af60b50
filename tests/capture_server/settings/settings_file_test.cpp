#include "capture_server/settings_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string error_of(const std::string& text) {
  const auto settings = parse_settings(text, "desk.toml");
  return settings ? "" : settings.error().what;
}

std::string repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

TEST(SettingsFile, GivesKeysAndValuesInTheOrderOfTheirLines) {
  const auto settings = parse_settings(
      "# the desk\nsource = \"desk #2.oni\"   # a path\n\ndepth-kbps = 1500\nloop = true\nscale = 0.5\n",
      "desk.toml");
  ASSERT_TRUE(settings) << settings.error().what;
  EXPECT_THAT(*settings, ElementsAre(Setting{"source", "desk #2.oni", 2}, Setting{"depth-kbps", "1500", 4},
                                     Setting{"loop", "true", 5}, Setting{"scale", "0.5", 6}));
}

TEST(SettingsFile, MayBeEmpty) {
  EXPECT_TRUE(parse_settings("", "desk.toml").value().empty());
}

TEST(SettingsFile, NamesTheLineOfWhatIsWrong) {
  EXPECT_THAT(error_of("loop = true\ndepth-kbps = \n"), HasSubstr("desk.toml:2: "));
  EXPECT_THAT(error_of("loop = true\nloop = false\n"), HasSubstr("desk.toml:2: "));
  EXPECT_THAT(error_of("\n\n[depth]\nkbps = 3\n"), HasSubstr("desk.toml:3: \"depth\" must be"));
  EXPECT_THAT(error_of("range = [0.4, 5]\n"), HasSubstr("desk.toml:1: \"range\" must be"));
}

TEST(SettingsFile, ThatIsNotThereIsNamed) {
  const auto settings = load_settings("/nowhere/desk.toml");
  ASSERT_FALSE(settings);
  EXPECT_THAT(settings.error().what, HasSubstr("there is no file /nowhere/desk.toml"));
}

TEST(SettingsFile, NamesAHugeKeyInAShortSentence) {
  const std::string key(500'000, 'k');
  const std::string what = error_of("\n" + key + " = [1]\n");
  EXPECT_THAT(what, HasSubstr("desk.toml:2: "));
  EXPECT_LT(what.size(), 400u);
}

TEST(SettingsFile, ThatNestsWithoutEndIsRefused) {
  EXPECT_THAT(error_of("a" + repeated(".a", 50'000) + " = 1\n"), HasSubstr("desk.toml:1: "));
  EXPECT_THAT(error_of("source = \"a" + repeated(".a", 50'000) + "\" = 1\n"), HasSubstr("desk.toml:1: "));
}

}  // namespace
}  // namespace copresence::server
