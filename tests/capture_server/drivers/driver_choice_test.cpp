#include "capture_server/drivers/contract/driver_choice.h"

#include <gtest/gtest.h>

namespace copresence::drivers {
namespace {

TEST(DriverChoice, EveryDriverWorksWhereNobodyChose) {
  unsetenv(kChoiceVariable);
  EXPECT_TRUE(is_chosen(kPrimeSense));
  EXPECT_TRUE(is_chosen(kSimulated));
}

TEST(DriverChoice, OnlyTheNamedOnesWork) {
  setenv(kChoiceVariable, "primesense,kinect_v1", 1);
  EXPECT_TRUE(is_chosen(kPrimeSense));
  EXPECT_TRUE(is_chosen(kKinectV1));
  EXPECT_FALSE(is_chosen(kSimulated));
  EXPECT_FALSE(is_chosen("prime"));
  setenv(kChoiceVariable, "none", 1);
  EXPECT_FALSE(is_chosen(kPrimeSense));
}

}  // namespace
}  // namespace copresence::drivers
