#pragma once

// Depth images whose true depth is known everywhere, holes included.

#include <algorithm>
#include <cstdlib>
#include <functional>

#include "capture_server/hole_filling/hole_filler.h"

namespace copresence::hole_filling {

inline constexpr DepthUnit kUnit = DepthUnit::k100Micrometres;

/// Difference of two depths in sensor steps.
inline double steps_apart(int a, int b) {
  return std::abs(351.3 * 1e4 / a - 351.3 * 1e4 / b);
}

struct Scene {
  DepthImage truth;
  RgbdFrame frame;

  /// `depth_m(x, y)` is the depth of a pixel, `is_hole(x, y)` where it is missing.
  static Scene make(int width, int height, const std::function<double(int, int)>& depth_m,
                    const std::function<bool(int, int)>& is_hole) {
    Scene scene{DepthImage(width, height), {}};
    scene.frame.state = StateImage(width, height, DepthState::kMeasured);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        scene.truth(x, y) = static_cast<std::uint16_t>(depth_m(x, y) * 1e4 + 0.5);
    }
    scene.frame.depth = scene.truth;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (is_hole(x, y)) scene.frame.depth(x, y) = 0, scene.frame.state(x, y) = DepthState::kHole;
      }
    }
    return scene;
  }

  FrameFormat format() const { return {truth.width(), truth.height(), kUnit, {}}; }

  int count(DepthState state) const {
    return static_cast<int>(std::count(frame.state.pixels().begin(), frame.state.pixels().end(), state));
  }
};

/// A plane that slants both ways, 1.2 m to 3 m away over 160x120 pixels: exactly linear in 1 / z, as planes
/// are.
inline double slanted_plane(int x, int y) {
  return 1 / (0.8 - 0.002 * x - 0.001 * y);
}

/// A board at 1 m before a wall at 3 m, its right edge at `edge`.
inline std::function<double(int, int)> board_before_wall(int edge) {
  return [edge](int x, int) { return x < edge ? 1.0 : 3.0; };
}

/// A scatter of holes up to 3 pixels wide; the same every time.
inline bool speckle(int x, int y) {
  const unsigned hash = static_cast<unsigned>((x / 3) * 73856093) ^ static_cast<unsigned>((y / 2) * 19349663);
  return (hash >> 4) % 7 == 0;
}

}  // namespace copresence::hole_filling
