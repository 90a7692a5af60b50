#pragma once

// One datagram of opentrack's output "UDP over network": six little-endian doubles, x, y, z in centimetres
// and yaw, pitch, roll in degrees. Positive is right, up and forward, and turned right, up and tilted to the
// right shoulder.
//
// Thread: pure.

#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace copresence::viewpoint {

struct HeadPose {
  double x_cm = 0, y_cm = 0, z_cm = 0;                          ///< within 500
  double yaw_degrees = 0, pitch_degrees = 0, roll_degrees = 0;  ///< within 180
};

/// Why a datagram is no head pose.
enum class DatagramFault {
  kSize,        ///< not 48 bytes
  kByteOrder,   ///< sensible numbers only when read as big-endian
  kNotFinite,   ///< a NaN or an infinity
  kOutOfRange,  ///< beyond 500 cm or 180 degrees
};
inline constexpr int kDatagramFaults = 4;
inline constexpr std::size_t kDatagramBytes = 6 * sizeof(double);

/// `received` is the beginning of the datagram, all of it where it is a valid one; `size` is the whole
/// datagram's.
tl::expected<HeadPose, DatagramFault> read_head_pose(std::span<const std::uint8_t> received,
                                                     std::size_t size);

/// What was received, as a part of a sentence: "36 bytes", "a z of -600 cm". Requires what read_head_pose()
/// was given.
std::string describe(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size);

/// What is expected instead, likewise.
std::string expected_datagram();

}  // namespace copresence::viewpoint
