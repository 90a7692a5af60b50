#pragma once

// Random numbers as pure functions of integers. The same seed, camera, frame and pixel always give
// the same number, in any order and on any thread.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"

namespace copresence::simulation {

/// Mixes 32 bits: each input bit flips about half of the output bits. Source: Wellons, lowbias32.
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

/// Maps a hash to a number from 0 to below 1. AVX2 can only convert signed integers.
constexpr float unit(std::uint32_t hashed) {
  return static_cast<float>(static_cast<std::int32_t>(hashed >> 8)) * 0x1p-24f;
}

/// Maps a hash to an approximately normal value with mean 0 and standard deviation 1, within +-3.5.
/// The result is the scaled sum of the four bytes.
constexpr float normal(std::uint32_t hashed) {
  const std::uint32_t sum = (hashed & 0xFF) + (hashed >> 8 & 0xFF) + (hashed >> 16 & 0xFF) + (hashed >> 24);
  return (static_cast<float>(static_cast<std::int32_t>(sum)) - 510.0f) * (1.0f / 147.8f);
}

/// Smooth noise in the plane, 0 to below 1: random values at whole coordinates, cubic between them.
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

/// Fills `noise` with normal values that are correlated over about `cell` pixels. Over the image,
/// the values have a mean of about 0 and a standard deviation of about 1. Requires cell >= 2.
void fill_blob_noise(int cell, std::uint32_t seed, Image<float>& noise);

/// One row of blob noise, interpolated on access between the lattice rows above and below.
struct BlobRow {
  const float* above;
  const float* below;
  float weight;  ///< Weight of `above`, 0 to 1.
  float operator[](std::size_t x) const { return below[x] + (above[x] - below[x]) * weight; }
};

/// Generates the image of fill_blob_noise() row by row, so that it need not be stored.
class BlobRows {
 public:
  /// Requires cell >= 2 and width > 0, both in pixels.
  BlobRows(int cell, std::uint32_t seed, int width);

  /// Returns the next row from the top. The row is valid until the next call.
  BlobRow next();

 private:
  void fill_lattice_row(std::uint32_t row, std::vector<float>& out);

  std::size_t cell_, width_;
  float gain_ = 0;
  std::size_t y_ = 0;
  std::vector<float> weight_;           // Weight of the left lattice point, per pixel of a cell.
  std::vector<std::uint32_t> columns_;  // Hashed column numbers of the lattice.
  std::vector<float> values_;           // Random values of one lattice row.
  std::vector<float> above_, below_;    // The lattice rows above and below y_, interpolated along the row.
};

}  // namespace copresence::simulation
