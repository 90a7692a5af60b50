#include "common/text/text_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

namespace copresence::text {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class TextFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  static std::string error_of(const fs::path& path) {
    const auto text = read_text_file(path, "a scene file", 1000);
    return text ? "" : text.error().what;
  }
  fs::path folder_ = fs::temp_directory_path() / ("copresence_text_" + std::to_string(getpid()));
};

TEST_F(TextFile, IsReadToItsLastByte) {
  std::string whole("a\0b\r\n", 5);
  whole.resize(1000, 'x');
  std::ofstream(folder_ / "file", std::ios::binary) << whole;
  EXPECT_EQ(read_text_file(folder_ / "file", "a scene file", 1000).value(), whole);
}

TEST_F(TextFile, SaysWhatIsInItsPlace) {
  EXPECT_THAT(error_of(folder_ / "no" / "file"),
              HasSubstr("there is no file " + (folder_ / "no/file").string()));
  EXPECT_THAT(error_of(folder_), HasSubstr("is a folder, not a scene file"));
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(error_of(folder_ / "pipe"), HasSubstr("not a regular file"));
  EXPECT_THAT(error_of("/dev/zero"), HasSubstr("not a regular file"));
  const std::string long_path = "/" + std::string(100'000, 'p');
  EXPECT_THAT(error_of(long_path), HasSubstr("cannot be read"));
  EXPECT_LT(error_of(long_path).size(), 500u);
}

TEST_F(TextFile, ThatIsTooLargeIsNotRead) {
  std::ofstream(folder_ / "large") << std::string(1001, 'x');
  EXPECT_THAT(error_of(folder_ / "large"), HasSubstr("too large for a scene file"));
  fs::resize_file(folder_ / "large", std::uintmax_t{1} << 40);  // a hole, which takes no place
  EXPECT_THAT(error_of(folder_ / "large"), HasSubstr("too large for a scene file"));
}

}  // namespace
}  // namespace copresence::text
