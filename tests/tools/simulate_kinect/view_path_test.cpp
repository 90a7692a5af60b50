#include "tools/simulate_kinect/view_path.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace copresence::simulate_kinect {
namespace {

class ViewPathTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  Result<ViewPath> load(const char* text) {
    std::ofstream(file_) << text;
    return ViewPath::load(file_);
  }
  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("copresence_path_" + std::to_string(getpid()));
};

TEST_F(ViewPathTest, IsLinearBetweenItsLinesAndStillBeyondThem) {
  const auto path = load("10 0 -1 0  0 -1 2\n20 1 -2 0  0 -1 4\n");
  ASSERT_TRUE(path) << path.error().what;
  EXPECT_EQ(path->at(0).eye, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(path->at(15).eye, Eigen::Vector3d(0.5, -1.5, 0));
  EXPECT_EQ(path->at(15).look, Eigen::Vector3d(0, -1, 3));
  EXPECT_EQ(path->at(99).look, Eigen::Vector3d(0, -1, 4));
}

TEST_F(ViewPathTest, RefusesLinesThatMakeNoSenseByTheirNumber) {
  for (const char* text : {"0 0 0 0 0 0 1\n0 0 0 0 0 0 1\n", "# two\n1 2 3\n", "# two\n0 0 0 0 0 0 1 9\n",
                           "# two\n0 a 0 0 0 0 1\n", "# two\n0 0 0 0 0 5 0\n"}) {
    const auto path = load(text);
    ASSERT_FALSE(path) << text;
    EXPECT_NE(path.error().what.find(":2:"), std::string::npos) << path.error().what;
  }
  EXPECT_FALSE(load(""));
  EXPECT_EQ(ViewPath::load("/nowhere/path").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace copresence::simulate_kinect
