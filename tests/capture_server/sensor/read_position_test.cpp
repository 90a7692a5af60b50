#include "capture_server/sensor/read_position.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/process.h"

namespace copresence::sensor {
namespace {

TEST(ReadPosition, IsThatOfOthersWhoReadTheSameFile) {
  const testing::TemporaryFolder folder;
  const std::string path = folder / "x";
  const int ours = ::open(path.c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(::write(ours, "0123456789", 10), 10);
  EXPECT_EQ(read_position_beside(ours), 0u);
  const int another = ::open(path.c_str(), O_RDONLY);
  char bytes[4];
  ASSERT_EQ(::read(another, bytes, 4), 4);
  EXPECT_EQ(read_position_beside(ours), 4u);
  EXPECT_EQ(read_position_beside(another), 10u);
  ::close(another);
  EXPECT_EQ(read_position_beside(ours), 0u);
  ::close(ours);
  EXPECT_EQ(read_position_beside(ours), 0u);
}

}  // namespace
}  // namespace copresence::sensor
