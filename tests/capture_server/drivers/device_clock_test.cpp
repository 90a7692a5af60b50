#include "capture_server/drivers/kinect_v1/device_clock.h"

#include <gtest/gtest.h>

namespace copresence::drivers {
namespace {

// What the camera stamps at a time, microseconds since it was powered.
std::uint32_t ticks_at(std::int64_t us) {
  return static_cast<std::uint32_t>(us * 60);
}

TEST(DeviceClock, CountsMicrosecondsOverEveryWrap) {
  DeviceClock clock;
  const std::int64_t powered = 70'000'000;  // it wraps 1.6 s later
  const std::uint64_t first = clock.to_us(ticks_at(powered), 5'000);
  std::uint64_t last = first;
  for (std::int64_t frame = 1; frame < 30 * 300; ++frame) {  // five minutes: four wraps
    const std::int64_t us = frame * 33'333;
    const std::int64_t jitter = frame % 7 * 900 - 2'000;
    const std::uint64_t now = clock.to_us(ticks_at(powered + us), 5'000 + us + jitter);
    ASSERT_NEAR(static_cast<double>(now - last), 33'333, 1);
    last = now;
  }
  EXPECT_NEAR(static_cast<double>(last - first), (30.0 * 300 - 1) * 33'333, 2);
}

TEST(DeviceClock, KnowsHowLongASilenceWas) {
  DeviceClock clock;
  const std::uint64_t before = clock.to_us(ticks_at(1'000'000), 0);
  const std::int64_t silence = 3'600'000'000;  // an hour: fifty wraps
  EXPECT_EQ(clock.to_us(ticks_at(1'000'000 + silence), silence + 4'000'000) - before,
            static_cast<std::uint64_t>(silence));
}

TEST(DeviceClock, TakesStreamsThatComeOutOfOrder) {
  DeviceClock clock;
  const std::uint64_t depth = clock.to_us(ticks_at(71'580'000), 0);
  const std::uint64_t color = clock.to_us(ticks_at(71'570'000), 100);  // older, though it came later
  EXPECT_EQ(depth - color, 10'000u);
  EXPECT_EQ(clock.to_us(ticks_at(71'600'000), 20'100) - depth, 20'000u);  // after the wrap
}

}  // namespace
}  // namespace copresence::drivers
