#include "capture_server/diagnosis/device_listing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace copresence::diagnosis {
namespace {

TEST(DeviceListing, ListsAtLeastTheSimulatedCamera) {
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
}  // namespace copresence::diagnosis
