#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture_server/sensor/device_source.h"

namespace copresence::sensor {
namespace {

TEST(DeviceSource, SaysWhenThereIsNoSuchCamera) {
  const auto source = open_device("freenect://nobody");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(source.error().what, testing::HasSubstr("freenect://nobody"));
  EXPECT_THAT(source.error().what, testing::HasSubstr("--list"));
}

}  // namespace
}  // namespace copresence::sensor
