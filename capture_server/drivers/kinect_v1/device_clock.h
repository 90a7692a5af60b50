#pragma once

// A Kinect's clock as microseconds that never wrap. The camera's timestamps are 32 bits of a 60 MHz
// counter, which wraps every 71.6 s. The clock counts the wraps by the time that has passed on the
// host, even after a long gap.
//
// Source: the OpenKinect protocol documentation (60 MHz).
// Thread: one thread at a time per object.

#include <cstdint>

namespace copresence::drivers {

class DeviceClock {
 public:
  static constexpr std::int64_t kTicksPerUs = 60;

  /// Converts the timestamp `ticks` of a picture to microseconds since an arbitrary zero. `host_us`
  /// is the present time on this machine's monotonic clock, with an error of at most half a wrap,
  /// 35 s. All streams of one device have the same clock and zero.
  std::uint64_t to_us(std::uint32_t ticks, std::int64_t host_us) {
    if (!begun_) {
      begun_ = true;
      // The added wrap keeps ticks_ positive if the first picture of another stream is older.
      ticks_ = (std::int64_t{1} << 32) + ticks;
      host_us_ = host_us;
    }
    const std::int64_t expected = ticks_ + (host_us - host_us_) * kTicksPerUs;
    const auto off = static_cast<std::int32_t>(ticks - static_cast<std::uint32_t>(expected));
    const std::int64_t unwrapped = expected + off;
    if (unwrapped > ticks_) {
      ticks_ = unwrapped;
      host_us_ = host_us;
    }
    return static_cast<std::uint64_t>(unwrapped / kTicksPerUs);
  }

 private:
  bool begun_ = false;
  std::int64_t ticks_ = 0, host_us_ = 0;
};

}  // namespace copresence::drivers
