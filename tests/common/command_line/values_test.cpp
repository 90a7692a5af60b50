#include "common/command_line/values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>

#include "common/command_line/parse_errors.h"

namespace copresence::command_line {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string wrong(const CLI::Validator& validator, const std::string& text) {
  return validator(text);
}

TEST(WholeNumber, TakesItsBoundsAndNothingBeyond) {
  const auto validator = whole_number(-2, 51);
  for (const char* text : {"-2", "0", "51"}) EXPECT_THAT(wrong(validator, text), IsEmpty());
  for (const char* text :
       {"-3", "52", "foo", "", "1.5", "nan", "1e1", "99999999999999999999", " 1", "1 ", "010", "0x1", "+1"})
    EXPECT_EQ(wrong(validator, text), "\"" + std::string(text) + "\" is not a whole number from -2 to 51");
}

TEST(WholeNumber, KnowsTheLargest) {
  constexpr auto kLargest = std::numeric_limits<std::uint64_t>::max();
  const auto validator = whole_number<std::uint64_t>(0, kLargest);
  EXPECT_THAT(wrong(validator, std::to_string(kLargest)), IsEmpty());
  EXPECT_THAT(wrong(validator, "18446744073709551616"), HasSubstr("is not"));
  EXPECT_THAT(wrong(validator, "-1"), HasSubstr("is not"));
}

TEST(Number, IsFiniteAndWithinItsBounds) {
  for (const char* text : {"0.1", "1000", "1e2"}) EXPECT_THAT(wrong(number(0.1, 1000), text), IsEmpty());
  for (const char* text : {"0.09", "1001", "nan", "inf", "-inf", "", "ten", "1,5"})
    EXPECT_THAT(wrong(number(0.1, 1000), text), HasSubstr("is not a number from 0.1 to 1000"));
  EXPECT_THAT(wrong(number_above_zero(10), "0"), HasSubstr("is not a number above 0, at most 10"));
  EXPECT_THAT(wrong(number_above_zero(10), "1e-9"), IsEmpty());
}

TEST(WritableFile, SaysWhyAFileCannotBeWrittenBeforeAnythingIsDone) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("copresence_values_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string file = (folder / "new.toml").string();
  EXPECT_THAT(wrong(writable_file(), file), IsEmpty());
  EXPECT_THAT(wrong(replaceable_file(), file), IsEmpty());
  EXPECT_THAT(wrong(writable_file(), "new.toml"), IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(wrong(writable_file(), "/nowhere/new.toml"),
            "\"/nowhere/new.toml\" is not a file that can be written: there is no folder /nowhere");
  EXPECT_THAT(wrong(replaceable_file(), folder.string()), HasSubstr("it is a folder"));
  EXPECT_EQ(wrong(writable_file(), ""), "\"\" is not a file's name");
  std::ofstream(file) << "kept";
  std::filesystem::permissions(file, std::filesystem::perms::owner_read);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_write,
                               std::filesystem::perm_options::remove);
  if (geteuid() != 0) {  // whom nothing is protected from
    EXPECT_THAT(wrong(writable_file(), file), HasSubstr("it is write-protected"));
    EXPECT_THAT(wrong(writable_file(), file + "2"), HasSubstr("you may not write in the folder"));
  }
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
  std::filesystem::remove_all(folder);
}

TEST(OneOf, NamesAllThatThereAre) {
  EXPECT_THAT(wrong(one_of({"auto", "gl", "cpu"}), "gl"), IsEmpty());
  EXPECT_EQ(wrong(one_of({"auto", "gl", "cpu"}), "gpu"), "\"gpu\" is not auto, gl or cpu");
  EXPECT_EQ(wrong(one_of({"auto", "fixed"}), ""), "\"\" is not auto or fixed");
  EXPECT_EQ(wrong(one_of({"room"}), "a"), "\"a\" is not room");
}

enum class Pace { kSlow = 3, kFast = 5 };

TEST(OneOf, BecomesTheValueThatAWordStandsFor) {
  CLI::App app;
  Pace pace = Pace::kSlow;
  app.add_option("--pace", pace)->transform(one_of<Pace>({{"slow", Pace::kSlow}, {"fast", Pace::kFast}}));
  app.parse("--pace fast");
  EXPECT_EQ(pace, Pace::kFast);
  try {
    app.parse("--pace 3");  // what it stands for is nobody's business
    FAIL();
  } catch (const CLI::ParseError& error) {
    EXPECT_EQ(parse_error_message(error), "--pace: \"3\" is not slow or fast");
  }
}

TEST(Size, IsEvenAndWithinItsLimits) {
  CLI::App app;
  int width = 640, height = 480;
  add_size(app, "--size", width, height, {16, 4096}, "");
  app.parse("--size 320x200");
  EXPECT_EQ(width, 320);
  EXPECT_EQ(height, 200);
  for (const char* text :
       {"321x200", "320x14", "320x4098", "320", "x", "320x", "320x200x1", "-320x200", "axb"})
    EXPECT_THROW(app.parse("--size=" + std::string(text)), CLI::ValidationError) << text;
}

TEST(DepthRangeOption, GoesFromNearToFar) {
  CLI::App app;
  DepthRange range;
  add_depth_range(app, "--range", range, "");
  app.parse("--range 0.05:65");
  EXPECT_EQ(range, (DepthRange{0.05, 65}));
  for (const char* text : {"0.04:5", "5:0.4", "1:1", "1:66", "1:nan", "nan:5", "near:far", "1", ":", "1:2:3"})
    EXPECT_THROW(app.parse("--range=" + std::string(text)), CLI::ValidationError) << text;
}

TEST(Mistakes, SayThatAValueIsMissing) {
  CLI::App app;
  std::string scene;
  app.add_option("--scene", scene);
  try {
    app.parse("--scene=");
    FAIL();
  } catch (const CLI::ParseError& error) {
    EXPECT_EQ(parse_error_message(error), "--scene needs a value");
  }
}

}  // namespace
}  // namespace copresence::command_line
