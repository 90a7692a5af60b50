#include "render_client/viewpoint/head_datagram.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

namespace copresence::viewpoint {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes little_endian(const std::vector<double>& values) {
  Bytes bytes;
  for (const double value : values) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
  return bytes;
}

Bytes big_endian(const std::vector<double>& values) {
  Bytes bytes = little_endian(values);
  for (std::size_t at = 0; at < bytes.size(); at += 8) std::reverse(&bytes[at], &bytes[at] + 8);
  return bytes;
}

/// The text for the log; empty for a pose.
std::string complaint(const Bytes& bytes) {
  const auto pose = read_head_pose(bytes, bytes.size());
  return pose ? "" : describe(pose.error(), bytes, bytes.size());
}

TEST(HeadDatagram, GivesThePose) {
  const Bytes bytes = little_endian({1, -2, 3, 40, -50, 60});
  const auto pose = read_head_pose(bytes, bytes.size());
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->x_cm, 1);
  EXPECT_EQ(pose->z_cm, 3);
  EXPECT_EQ(pose->yaw_degrees, 40);
  EXPECT_EQ(pose->roll_degrees, 60);
}

// Small whole numbers in the other byte order are denormal numbers. They must not count as a pose
// of almost zero.
TEST(HeadDatagram, NamesTheOtherByteOrder) {
  EXPECT_THAT(complaint(big_endian({0, 0, 0, 128, 1, -4})), testing::HasSubstr("big-endian"));
  EXPECT_THAT(complaint(big_endian({0.1, 12.7, -3.3, 128.123, 1.7, -4})), testing::HasSubstr("big-endian"));
  EXPECT_THAT(complaint(big_endian({0, 0, 0, 0, 0, 0.5})), testing::HasSubstr("big-endian"));
}

TEST(HeadDatagram, TakesWhatAFilterSendsThatFadesToZero) {
  EXPECT_EQ(complaint(little_endian({0, 0, 0, 0, 0, 0})), "");
  EXPECT_EQ(complaint(little_endian({1e-17, -1e-12, 3, 4, 5, 6})), "");
  EXPECT_EQ(complaint(little_endian({3e-310, 1.7e-308, 2.1e-120, 12.3, 0, 0})), "");
}

TEST(HeadDatagram, NamesWhatIsWrong) {
  EXPECT_EQ(complaint(Bytes(36, 0)), "36 bytes");
  EXPECT_EQ(complaint({}), "0 bytes");
  const std::string json = "{\"yaw\": 1.5}\n";
  EXPECT_EQ(complaint({json.begin(), json.end()}), "a text of 13 bytes, \"{\"yaw\": 1.5}?\"");
  EXPECT_EQ(complaint(little_endian({0, 0, -600, 0, 0, 0})), "a z of -600 cm");
  EXPECT_EQ(complaint(little_endian({0, 0, 0, 0, 181, 0})), "a pitch of 181 degrees");
  EXPECT_EQ(complaint(little_endian({0, 1, std::numeric_limits<double>::quiet_NaN(), 0, 181, 0})),
            "a z of nan cm");
}

}  // namespace
}  // namespace copresence::viewpoint
