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
    EXPECT_TRUE(device.ready || !device.problems.empty()) << device.name;
    if (!device.source.starts_with("simulated:")) continue;
    simulated = true;
    EXPECT_TRUE(device.ready);
    EXPECT_EQ(device.serial, "SIM0");
    EXPECT_THAT(device.modes, testing::Contains("depth 640x480 at 30, 1 mm"));
  }
  EXPECT_TRUE(simulated);
}

}  // namespace
}  // namespace copresence::sensor
