#pragma once

// Synthetic depth images as of a Kinect v1: a slanted wall, a nearer disc that moves, noise of one
// step, holes in the disc's shadow and at the right border. Deterministic.

#include <cmath>
#include <cstdint>
#include <random>

#include "common/frame/image.h"

namespace copresence::depth::testing {

struct Scene {
  DepthImage depth;
  StateImage state;
};

/// A Kinect's depth level nearest to `z` millimetres.
inline std::uint16_t kinect_level(double z_mm) {
  const double disparity = std::round(351300.0 / z_mm);
  return static_cast<std::uint16_t>(std::lround(351300.0 / disparity));
}

/// The image of frame `time`, with every fifth row of the shadow filled. Millimetres, 0.9 m to 4 m.
inline Scene kinect_scene(int width, int height, int time = 0) {
  Scene scene{DepthImage(width, height, 0), StateImage(width, height, DepthState::kHole)};
  std::minstd_rand random(static_cast<unsigned>(time) + 1);
  const double radius = height * 0.25, x0 = width * 0.4 + time, y0 = height * 0.5;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto inside = [&](double at) {
        return (at - x0) * (at - x0) + (y - y0) * (y - y0) < radius * radius;
      };
      double z = inside(x) ? 900.0 + y : 2000.0 + 2000.0 * x / width;
      z += (random() % 8 == 0 ? 1.0 : 0.0) * z * z / 351300.0;
      const bool shadow = !inside(x) && inside(x + width / 40.0);
      const bool margin = x >= width - 8 || random() % 2000 == 0;
      if (margin || (shadow && y % 5 != 0)) continue;
      scene.depth(x, y) = kinect_level(z);
      scene.state(x, y) = shadow ? DepthState::kFilled : DepthState::kMeasured;
    }
  }
  return scene;
}

/// The same depth everywhere, measured.
inline Scene flat_scene(int width, int height, std::uint16_t depth) {
  return {DepthImage(width, height, depth),
          StateImage(width, height, depth ? DepthState::kMeasured : DepthState::kHole)};
}

}  // namespace copresence::depth::testing
