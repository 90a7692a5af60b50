#pragma once

// A datagram of opentrack's output "UDP over network": six little-endian doubles. These are x, y, z
// in centimetres, then yaw, pitch, roll in degrees. Positive means right, up and forward; turned
// right, turned up, and tilted to the right shoulder.
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

/// Why a datagram is not a head pose.
enum class DatagramFault {
  kSize,        ///< not 48 bytes
  kByteOrder,   ///< plausible numbers only if read as big-endian
  kNotFinite,   ///< a NaN or an infinity
  kOutOfRange,  ///< beyond 500 cm or 180 degrees
};
inline constexpr int kDatagramFaults = 4;
inline constexpr std::size_t kDatagramBytes = 6 * sizeof(double);

/// `received` is the datagram, or its beginning if it is too long to be valid. `size` is the size
/// of the whole datagram.
tl::expected<HeadPose, DatagramFault> read_head_pose(std::span<const std::uint8_t> received,
                                                     std::size_t size);

/// Describes what was received, as a part of a sentence: "36 bytes", "a z of -600 cm". Takes the
/// arguments of read_head_pose().
std::string describe(DatagramFault fault, std::span<const std::uint8_t> received, std::size_t size);

/// Describes a valid datagram, as a part of a sentence.
std::string expected_datagram();

}  // namespace copresence::viewpoint
