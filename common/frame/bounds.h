#pragma once

// Bounds for numbers from untrusted input: the wire, a stream's side data, files. Two numbers of
// the same kind within these bounds can be added and subtracted without overflow. Thread: pure.

#include <cstdint>
#include <optional>

#include "common/frame/depth_unit.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence {

/// Upper bound of counters and of times in nanoseconds; 2^61 ns are 73 years.
inline constexpr std::uint64_t kNumberBound = std::uint64_t{1} << 61;
inline constexpr double kFarthestCameraMetres = 1e4;

inline bool is_within_bounds(std::uint64_t number) {
  return number < kNumberBound;
}

/// Returns the instant that lies `nanoseconds` after its clock's zero, or nothing if the number is
/// out of bounds. Negative numbers read as unsigned are out of bounds, too.
std::optional<Instant> instant_from_nanoseconds(std::uint64_t nanoseconds);

/// Fails with kInvalid unless the transform is rigid and moves by at most 10 km along each axis.
Result<void> check_pose(const Rigid3& world_from_camera);

/// Fails with kInvalid unless the numbers are within the ranges of DepthNoise.
Result<void> check_noise(const DepthNoise& noise);

}  // namespace copresence
