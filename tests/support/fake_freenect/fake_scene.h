#pragma once

// The scene of every fake Kinect: a wall that is farther away on the right, and a disc that moves
// in front of the wall. Thread: pure functions.

#include <cstdint>
#include <vector>

namespace copresence::fake_freenect {

inline constexpr int kWidth = 640, kHeight = 480;
inline constexpr int kRegisteredShift = 8;  ///< Shift of registered depth to the left, pixels.

constexpr bool on_disc(int x, int y, std::uint64_t frame) {
  const int dx = x - (160 + static_cast<int>(frame * 4 % 320)), dy = y - 240;
  return dx * dx + dy * dy < 60 * 60;
}

/// Depth in millimetres. The rightmost eight columns are 0, as in a real Kinect.
constexpr std::uint16_t depth_at(int x, int y, std::uint64_t frame, bool registered) {
  if (x >= kWidth - 8) return 0;
  const int seen = registered ? x + kRegisteredShift : x;
  return on_disc(seen, y, frame) ? std::uint16_t{1200} : static_cast<std::uint16_t>(2000 + seen);
}

/// The depth of each of 2048 disparities in millimetres, 0 for none. As in a Kinect, depth grows
/// with the disparity value.
constexpr std::uint16_t depth_of_disparity(int disparity) {
  return disparity < 80 ? std::uint16_t{0} : static_cast<std::uint16_t>(351300 / (2128 - disparity));
}
/// All distinct depths in ascending order.
inline std::vector<std::uint16_t> levels() {
  std::vector<std::uint16_t> levels;
  for (int disparity = 80; disparity < 2048; ++disparity) {
    const std::uint16_t level = depth_of_disparity(disparity);
    if (levels.empty() || level > levels.back()) levels.push_back(level);
  }
  return levels;
}

struct Color {
  std::uint8_t r, g, b;
};
constexpr Color color_at(int x, int y, std::uint64_t frame) {
  if (on_disc(x, y, frame)) return {220, 60, 40};
  return {static_cast<std::uint8_t>(x / 4), static_cast<std::uint8_t>(y / 2),
          static_cast<std::uint8_t>(frame)};
}

constexpr std::uint8_t infrared_at(int x, int y, std::uint64_t frame) {
  return on_disc(x, y, frame) ? std::uint8_t{200} : static_cast<std::uint8_t>((x ^ y) & 63);
}

}  // namespace copresence::fake_freenect
