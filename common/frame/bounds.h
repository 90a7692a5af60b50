#pragma once

// Bounds of numbers that come from strangers: over the wire, in a stream's side data, in a file. What passes
// can be added to and subtracted from another number of its kind without overflow.
//
// Thread: pure.

#include <cstdint>
#include <optional>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence {

/// Times in nanoseconds and counters are below this: 2^61 ns are 73 years.
inline constexpr std::uint64_t kNumberBound = std::uint64_t{1} << 61;
inline constexpr double kFarthestCameraMetres = 1e4;

inline bool is_within_bounds(std::uint64_t number) {
  return number < kNumberBound;
}

/// An instant from its clock's nanoseconds; nothing beyond the bound, nor for a negative number read as an
/// unsigned one.
std::optional<Instant> instant_from_nanoseconds(std::uint64_t nanoseconds);

/// A rigid transform with a translation of at most 10 km along each axis. Fails with kInvalid.
Result<void> check_pose(const Rigid3& world_from_camera);

}  // namespace copresence
