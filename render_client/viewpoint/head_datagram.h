#pragma once

// Reads datagrams of opentrack's output "UDP over network". A datagram has six little-endian
// doubles: x, y, z in centimetres, then yaw, pitch, roll in degrees. Positive x, y and z mean a
// motion to the right, up and forward. Positive angles mean that the head turns right, turns up and
// tilts to the right shoulder. Thread: pure functions.

#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace copresence::viewpoint {

struct HeadPose {
  double x_cm = 0, y_cm = 0, z_cm = 0;                          ///< From -500 to 500.
  double yaw_degrees = 0, pitch_degrees = 0, roll_degrees = 0;  ///< From -180 to 180.
};

/// The reason why a datagram is not a head pose.
enum class DatagramFault {
  kSize,        ///< The size is not 48 bytes.
  kByteOrder,   ///< The numbers are plausible only if they are read as big-endian.
  kNotFinite,   ///< A number is a NaN or an infinity.
  kOutOfRange,  ///< A number is beyond 500 cm or 180 degrees.
};
inline constexpr int kDatagramFaults = 4;
inline constexpr std::size_t kDatagramBytes = 6 * sizeof(double);

/// Reads a datagram. If the datagram is too long to be valid, `received` may be only its beginning.
/// `size` is the size of the whole datagram.
tl::expected<HeadPose, DatagramFault> read_head_pose(std::span<const std::uint8_t> received,
                                                     std::size_t size);

/// Describes an invalid datagram as a part of a sentence: "36 bytes" or "a z of -600 cm". Takes the
/// arguments of read_head_pose().
std::string describe(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size);

/// Describes a valid datagram as a part of a sentence.
std::string expected_datagram();

}  // namespace copresence::viewpoint
