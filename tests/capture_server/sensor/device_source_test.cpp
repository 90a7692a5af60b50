#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {
namespace {

TEST(DeviceSource, SaysWhenThereIsNoSuchCamera) {
  const auto source = open_device("freenect://nobody");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(source.error().what, testing::HasSubstr("freenect://nobody"));
  EXPECT_THAT(source.error().what, testing::HasSubstr("--list"));
}

TEST(DeviceSource, ListsAtLeastTheSimulatedCamera) {
  const auto listing = list_devices();
  ASSERT_TRUE(listing) << listing.error().what;
  bool simulated = false;
  for (const DeviceListing& device : *listing) {
    EXPECT_FALSE(device.uri.empty());
    simulated = simulated || device.uri.starts_with("simulated:");
  }
  EXPECT_TRUE(simulated);
}

}  // namespace
}  // namespace copresence::sensor
