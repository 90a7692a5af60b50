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

/// What every UV stands for, entry u * 256 + v: the index of the nearest point, and kOffPoint where it lies off that point by
/// more than video coding without much loss moves it.
std::vector<std::uint8_t> nearest_spiral_point();

inline constexpr std::uint8_t kOffPoint = 0x80;

}  // namespace copresence::depth
