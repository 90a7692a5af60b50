#include "common/file/output_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "tests/support/recording_scene.h"

namespace copresence::file {
namespace {

using ::testing::HasSubstr;

constexpr std::array<std::uint8_t, 3> kBytes{'n', 'e', 'w'};

class OutputFileTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.file(name); }
  void make(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::string text_of(const std::string& name) const {
    const auto bytes = test::bytes_of(path(name));
    return {bytes.begin(), bytes.end()};
  }

  const test::TemporaryFolder folder_;
};

TEST_F(OutputFileTest, KeepsAFileThatExists) {
  make("a.oni", "old");
  const auto file = OutputFile::create(path("a.oni"));
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(file.error().what, HasSubstr(path("a.oni") + ": exists already"));
  EXPECT_EQ(text_of("a.oni"), "old");
}

TEST_F(OutputFileTest, KeepsAnEmptyFileToo) {
  make("a.oni", "");
  EXPECT_FALSE(OutputFile::create(path("a.oni")));
}

TEST_F(OutputFileTest, ReplacesAFileWhereAskedTo) {
  make("a.oni", "older and longer");
  auto file = OutputFile::create(path("a.oni"), Existing::kReplace);
  ASSERT_TRUE(file) << file.error().what;
  ASSERT_TRUE(file->append(kBytes) && file->close());
  EXPECT_EQ(text_of("a.oni"), "new");
}

TEST_F(OutputFileTest, TakesALinkThatLeadsNowhereForATakenName) {
  std::filesystem::create_symlink(path("nothing"), path("a.oni"));
  EXPECT_EQ(OutputFile::create(path("a.oni")).error().code, ErrorCode::kInvalid);
  EXPECT_FALSE(std::filesystem::exists(path("nothing")));
}

TEST_F(OutputFileTest, OpensADeviceAsItIs) {
  EXPECT_TRUE(OutputFile::create("/dev/null"));
  EXPECT_TRUE(OutputFile::create_numbered("/dev/null"));
  EXPECT_FALSE(std::filesystem::exists("/dev/null-2"));
}

TEST_F(OutputFileTest, SaysOfAFolderAndOfAPipeThatNobodyReadsThatTheyCannotBeWritten) {
  EXPECT_EQ(OutputFile::create(path("")).error().code, ErrorCode::kUnavailable);
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_EQ(OutputFile::create(path("pipe")).error().code, ErrorCode::kUnavailable);  // and returns at all
}

TEST_F(OutputFileTest, NumbersNamesThatAreTaken) {
  make("a.oni", "old");
  make("a-3.oni", "old");
  for (const char* expected : {"a-2.oni", "a-4.oni"}) {
    auto file = OutputFile::create_numbered(path("a.oni"));
    ASSERT_TRUE(file) << file.error().what;
    EXPECT_EQ(file->path(), path(expected));
  }
  EXPECT_EQ(text_of("a-3.oni"), "old");
}

TEST_F(OutputFileTest, GivesEachOfManyAtOnceAFileOfItsOwn) {
  constexpr std::size_t kWriters = 8, kRounds = 20;
  std::array<std::set<std::string>, kWriters> names;
  {
    std::vector<std::jthread> writers;
    for (std::size_t writer = 0; writer < kWriters; ++writer) {
      writers.emplace_back([&, writer] {
        for (std::size_t round = 0; round < kRounds; ++round) {
          if (auto file = OutputFile::create_numbered(path("a.oni"))) names[writer].insert(file->path());
        }
      });
    }
  }
  std::set<std::string> all;
  for (const auto& some : names) all.insert(some.begin(), some.end());
  EXPECT_EQ(all.size(), kWriters * kRounds);
}

TEST_F(OutputFileTest, GivesUpAfterTenThousandNamesWithoutOverwriting) {
  make("a.oni", "old");
  for (int i = 2; i <= 10'000; ++i) make("a-" + std::to_string(i) + ".oni", "old");
  const auto file = OutputFile::create_numbered(path("a.oni"));
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().what, HasSubstr("all up to " + path("a-10000.oni")));
  EXPECT_EQ(text_of("a-10000.oni"), "old");
}

}  // namespace
}  // namespace copresence::file
