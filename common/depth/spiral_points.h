#pragma once

// The 32 points of the spiral codec in the UV plane, and the way back from any UV to the nearest of them.
// Thread: pure.

#include <array>
#include <cstdint>
#include <vector>

namespace copresence::depth {

struct ChromaPoint {
  std::uint8_t u, v;
};

inline constexpr int kSpiralPoints = 32;

/// Neighbours on the spiral and on its next turn are 38 codes apart or more.
std::array<ChromaPoint, kSpiralPoints> spiral_points();

/// Index of the nearest point for every UV: entry u * 256 + v.
std::vector<std::uint8_t> nearest_spiral_point();

}  // namespace copresence::depth
