#include "common/frame/bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace copresence {
namespace {

TEST(Bounds, TakesNoTimeThatArithmeticCouldOverflow) {
  EXPECT_EQ(instant_from_nanoseconds(0), Instant{});
  EXPECT_EQ(instant_from_nanoseconds(kNumberBound - 1)->time_since_epoch(),
            std::chrono::nanoseconds(kNumberBound - 1));
  EXPECT_FALSE(instant_from_nanoseconds(kNumberBound));
  EXPECT_FALSE(instant_from_nanoseconds(static_cast<std::uint64_t>(std::int64_t{-1})));
  EXPECT_FALSE(
      instant_from_nanoseconds(static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::min())));
  EXPECT_FALSE(
      instant_from_nanoseconds(static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())));
}

TEST(Bounds, HoldsAPoseToTenKilometres) {
  Rigid3 pose;
  EXPECT_TRUE(check_pose(pose));
  for (const double metres : {1e4, -1e4}) {
    pose.translation = {0, metres, 0};
    EXPECT_TRUE(check_pose(pose));
  }
  for (const double metres : {10001.0, -1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    pose.translation = {0, 0, metres};
    EXPECT_FALSE(check_pose(pose)) << metres;
  }
  pose = {};
  pose.rotation(0, 0) = -1;
  EXPECT_FALSE(check_pose(pose)) << "a mirror";
}

TEST(Bounds, HoldsANoiseToWhatSensorsHave) {
  EXPECT_TRUE(check_noise(kKinectV1Noise));
  for (const double constant : {50.0, 1e5}) EXPECT_TRUE(check_noise({constant, 0.5}));
  for (const double sigma : {0.01, 100.0}) EXPECT_TRUE(check_noise({351.3, sigma}));
  for (const double wrong :
       {0.0, -351.3, 49.0, 1.1e5, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_FALSE(check_noise({wrong, 0.5})) << wrong;
  }
  for (const double wrong : {0.0, -0.5, 0.009, 101.0, std::nan("")})
    EXPECT_FALSE(check_noise({351.3, wrong})) << wrong;
}

}  // namespace
}  // namespace copresence
