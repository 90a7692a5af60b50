// OpenNI2's own toy device stands in for a camera: 320x240, depth and colour, no field of view.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture_server/sensor/frame_source.h"

namespace copresence::sensor {
namespace {

TEST(DeviceSource, GivesFramesOfWhateverDeviceOpenNi2Opens) {
  const auto source = open_device("Dummy");
  ASSERT_TRUE(source) << source.error().what;
  const SensorDescription& description = (*source)->description();
  EXPECT_EQ(description.depth.width, 320);
  EXPECT_EQ(description.depth.height, 240);
  EXPECT_TRUE(check(description.depth));
  EXPECT_FALSE(description.is_recording);
  EXPECT_FALSE(description.frames);
  for (std::uint64_t i = 1; i <= 5; ++i) {
    const auto frame = (*source)->next({});
    ASSERT_TRUE(frame) << frame.error().what;
    EXPECT_EQ(frame->stamp.sequence, i);
    EXPECT_EQ(frame->depth.width(), 320);
    EXPECT_EQ(frame->color.has_value(), description.has_color);
    EXPECT_LE(frame->stamp.captured_at, std::chrono::steady_clock::now());
  }
}

TEST(DeviceSource, SaysWhenThereIsNoSuchCamera) {
  const auto source = open_device("freenect://nobody");
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(source.error().what, testing::HasSubstr("freenect://nobody"));
  EXPECT_THAT(source.error().what, testing::HasSubstr("--list"));
}

TEST(DeviceSource, ListsCamerasEvenWhereThereIsNone) {
  const auto listing = list_devices();
  ASSERT_TRUE(listing) << listing.error().what;
  for (const DeviceListing& device : *listing) EXPECT_FALSE(device.uri.empty());
}

}  // namespace
}  // namespace copresence::sensor
