#pragma once

// Private to materials: the shapes of patterns, and the patterns that are evaluated point by point.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "simulation/scene/material.h"
#include "simulation/scene/noise.h"

namespace copresence::simulation {

template <class Value>
Value mix_colors(const Value& a, const Value& b, float share) {
  return a + (b - a) * share;
}

inline float fraction(float x) {
  return x - std::floor(x);
}

// Returns the number of the cell of length 1 that contains x, modulo 2^32.
inline std::uint32_t cell(float x) {
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(x)));
}

inline float clamp_to_unit(float x) {
  return std::min(std::max(x, 0.0f), 1.0f);
}

// Returns 0 below the edge, 1 above it, and a linear ramp of the given width in between.
inline float step(float edge, float x, float width) {
  return clamp_to_unit((x - edge) / width + 0.5f);
}

// Returns 1 on a line of the given half width around x = 0, and 0 elsewhere. Edges are `soft` wide.
inline float line(float x, float half_width, float soft) {
  return 1 - step(half_width, std::abs(x), soft);
}

// Returns irregular light and dark patches, -0.5 to 0.5.
inline float mottle(float x, float y, std::uint32_t seed) {
  return 0.6f * value_noise(x, y, seed) + 0.4f * value_noise(2.3f * x, 2.3f * y, seed + 1) - 0.5f;
}

/// Returns the colour of a pattern that albedo() does not evaluate in batches.
Eigen::Vector3f color_at_point(const Material& material, const Eigen::Vector2f& uv);

}  // namespace copresence::simulation
