#include "common/text/secret_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

namespace copresence::text {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

class SecretFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_ = fs::temp_directory_path() / ("copresence_secret_" + std::to_string(getpid()));
  fs::path path_ = folder_ / "file";
};

TEST(Secret, HasItsDigitsAndDiffersEachTime) {
  const auto one = make_secret(), other = make_secret();
  ASSERT_TRUE(one && other);
  EXPECT_THAT(*one, MatchesRegex("[0-9a-f]{64}"));
  EXPECT_NE(*one, *other);
}

TEST_F(SecretFile, IsWrittenForItsOwnerOnlyAndReadBack) {
  ASSERT_TRUE(write_secret_file(path_, "abc\n", "token"));
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(read_secret_file(path_, "a token file").value(), "abc\n");
}

TEST_F(SecretFile, IsNeverOverwritten) {
  ASSERT_TRUE(write_secret_file(path_, "abc\n", "token"));
  const auto again = write_secret_file(path_, "def\n", "token");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(read_secret_file(path_, "a token file").value(), "abc\n");
}

TEST_F(SecretFile, ThatOthersCanReadOrChangeIsRefusedWithoutQuotingIt) {
  ASSERT_TRUE(write_secret_file(path_, "abc\n", "token"));
  for (const auto others : {fs::perms::group_read, fs::perms::others_write}) {
    fs::permissions(path_, fs::perms::owner_read | others);
    const auto text = read_secret_file(path_, "a token file");
    ASSERT_FALSE(text);
    EXPECT_THAT(text.error().what, HasSubstr("chmod 600"));
    EXPECT_THAT(text.error().what, Not(HasSubstr("abc")));
  }
}

TEST_F(SecretFile, InAFolderThatDoesNotExistCannotBeWritten) {
  const auto written = write_secret_file(folder_ / "no" / "file", "abc\n", "token");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace copresence::text
