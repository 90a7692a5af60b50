#pragma once

// Randomness that is a pure function of integers: the same for the same seed, camera, frame and pixel,
// whatever the order or the thread in which it is asked for.

#include <cmath>
#include <cstdint>

namespace copresence::simulation {

/// Mixes 32 bits so that each bit of the input moves half of the output's. Source: Wellons' "lowbias32".
constexpr std::uint32_t mix(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7FEB352Du;
  x ^= x >> 15;
  x *= 0x846CA68Bu;
  x ^= x >> 16;
  return x;
}

constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b) {
  return mix(a * 0x9E3779B9u + mix(b));
}
constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return hash(hash(a, b), c);
}

/// 0 <= result < 1.
constexpr float unit(std::uint32_t hashed) {
  return static_cast<float>(static_cast<std::int32_t>(hashed >> 8)) *
         0x1p-24f;  // signed: one instruction for eight
}

/// Approximately normal, mean 0, standard deviation 1, within +-3.5: the sum of the four bytes.
constexpr float normal(std::uint32_t hashed) {
  const std::uint32_t sum = (hashed & 0xFF) + (hashed >> 8 & 0xFF) + (hashed >> 16 & 0xFF) + (hashed >> 24);
  return (static_cast<float>(static_cast<std::int32_t>(sum)) - 510.0f) * (1.0f / 147.8f);
}

/// Smooth noise in the plane: hashed values at whole coordinates, between them cubic steps. 0 <= result < 1.
inline float value_noise(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const auto ix = static_cast<std::uint32_t>(static_cast<std::int32_t>(fx));
  const auto iy = static_cast<std::uint32_t>(static_cast<std::int32_t>(fy));
  const auto smooth = [](float t) { return t * t * (3 - 2 * t); };
  const float u = smooth(x - fx), v = smooth(y - fy);
  const float a = unit(hash(seed, ix, iy)), b = unit(hash(seed, ix + 1, iy));
  const float c = unit(hash(seed, ix, iy + 1)), d = unit(hash(seed, ix + 1, iy + 1));
  return (a + (b - a) * u) * (1 - v) + (c + (d - c) * u) * v;
}

}  // namespace copresence::simulation
