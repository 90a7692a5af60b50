#pragma once

// A Kinect's clock as microseconds that never wrap. The camera stamps pictures with 32 bits of a 60 MHz counter, which
// begins anew every 71.6 s; the time that passed in the host says how many times it did, however long nothing came.
//
// Source: the OpenKinect protocol documentation (60 MHz).
// Thread: a value.

#include <cstdint>

namespace copresence::drivers {

class DeviceClock {
 public:
  static constexpr std::int64_t kTicksPerUs = 60;

  /// When the picture stamped `ticks` was taken, counted from an arbitrary zero. `host_us`: this machine's monotonic
  /// clock, now; right to half a round, 35 s. Streams of one device share one clock and so one zero.
  std::uint64_t to_us(std::uint32_t ticks, std::int64_t host_us) {
    if (!begun_) {
      begun_ = true;
      ticks_ = (std::int64_t{1} << 32) + ticks;  // another stream's first picture may be older
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
