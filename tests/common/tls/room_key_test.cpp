#include "common/tls/room_key.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <set>

namespace copresence::tls {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string kDigits = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F";

std::string error_of(const std::string& text) {
  const auto key = parse_key(text, "room.key");
  return key ? "" : key.error().what;
}

TEST(RoomKey, IsReadFromItsDigits) {
  for (const std::string& text :
       {kDigits, kDigits + "\n", "# a comment\n\n" + kDigits + " \r\n# another\r\n"}) {
    const auto key = parse_key(text, "room.key");
    ASSERT_TRUE(key) << key.error().what;
    for (std::size_t i = 0; i < RoomKey::kBytes; ++i) EXPECT_EQ(key->bytes()[i], i);
  }
}

TEST(RoomKey, RejectsEverythingElseWithoutQuotingIt) {
  const std::string secret = "ThisIsMyPasswordForEverything";
  for (const std::string& text :
       {std::string(), std::string("\n\n#\n"), secret, secret + "\n" + kDigits, kDigits + "\n" + secret,
        kDigits + "\n" + kDigits, kDigits.substr(1), kDigits + "0", "g" + kDigits.substr(1), " " + kDigits,
        "0x" + kDigits.substr(2), std::string("\0", 1) + kDigits, std::string(64, '\xff')}) {
    const std::string error = error_of(text);
    EXPECT_THAT(error, HasSubstr("room.key: it"));
    EXPECT_THAT(error, HasSubstr("--make-key"));
    EXPECT_THAT(error, Not(HasSubstr("Password")));
    EXPECT_THAT(error, Not(HasSubstr("0a0b0c")));
  }
}

class KeyFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  static std::string error_of(const fs::path& path) {
    const auto key = read_key(path);
    return key ? "" : key.error().what;
  }
  static std::string text_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder_ = fs::temp_directory_path() / ("copresence_key_" + std::to_string(getpid()));
  fs::path file_ = folder_ / "room.key";
};

TEST_F(KeyFile, IsMadeForItsOwnerOnlyAndReadBack) {
  ASSERT_TRUE(make_key(file_));
  EXPECT_EQ(fs::status(file_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(read_key(file_)) << error_of(file_);
  EXPECT_THAT(text_of(file_), HasSubstr("# Copresence room key."));
}

TEST_F(KeyFile, HasAnotherKeyEachTime) {
  std::set<std::string> texts;
  for (int i = 0; i < 20; ++i) {
    const fs::path file = folder_ / std::to_string(i);
    ASSERT_TRUE(make_key(file));
    texts.insert(text_of(file));
  }
  EXPECT_EQ(texts.size(), 20u);
}

TEST_F(KeyFile, IsNeverOverwritten) {
  std::ofstream(file_) << "precious";
  fs::create_symlink("nowhere", folder_ / "link");
  for (const fs::path& taken : {file_, folder_ / "link", folder_}) {
    const auto made = make_key(taken);
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().what, HasSubstr("exists already and is kept"));
  }
  EXPECT_EQ(text_of(file_), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
  EXPECT_THAT(make_key(folder_ / "no" / "room.key").error().what, HasSubstr("cannot be written"));
}

TEST_F(KeyFile, ThatOthersMayReadOrChangeIsRefused) {
  ASSERT_TRUE(make_key(file_));
  for (const mode_t mode : {0640, 0604, 0620, 0666, 0601}) {
    ASSERT_EQ(::chmod(file_.c_str(), mode), 0);
    const auto key = read_key(file_);
    ASSERT_FALSE(key) << mode;
    EXPECT_EQ(key.error().code, ErrorCode::kInvalid);
    EXPECT_THAT(key.error().what, HasSubstr("chmod 600 " + file_.string()));
  }
  ASSERT_EQ(::chmod(file_.c_str(), 0400), 0);
  EXPECT_TRUE(read_key(file_));
}

TEST_F(KeyFile, SaysWhatIsInItsPlace) {
  EXPECT_THAT(error_of(file_), HasSubstr("there is no file " + file_.string()));
  EXPECT_THAT(error_of(folder_), HasSubstr("is a folder, not a key file"));
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  EXPECT_THAT(error_of(file_), HasSubstr("not a regular file"));
  std::ofstream(folder_ / "large") << std::string(5000, '#');
  ASSERT_EQ(::chmod((folder_ / "large").c_str(), 0600), 0);
  EXPECT_THAT(error_of(folder_ / "large"), HasSubstr("too large for a key file"));
}

}  // namespace
}  // namespace copresence::tls
