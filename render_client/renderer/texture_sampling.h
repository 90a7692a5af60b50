#pragma once

// Bilinear samples of a Texture, eight at a time. Private to the CPU renderer. Thread: pure.

#include <array>
#include <cstdint>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/projection.h"

namespace copresence::renderer {

/// Where eight samples are taken: the texel above and left of each, its texture's row length, and the
/// fractions in 1/kTexelSteps.
struct SamplePoints {
  std::array<const std::uint32_t*, kLanes> texel;
  std::array<std::ptrdiff_t, kLanes> row;
  alignas(32) std::array<std::int32_t, kLanes> across, down;
};

namespace sampling {

using Bytes = std::uint8_t __attribute__((vector_size(16)));
using Words = std::uint16_t __attribute__((vector_size(32)));
using HalfWords = std::uint16_t __attribute__((vector_size(16)));

// Four channels of the left texel, then four of the right one.
struct Weights {
  alignas(16) std::uint16_t words[kTexelSteps][kLanes];
};
constexpr Weights across_weights() {
  Weights table{};
  for (int f = 0; f < kTexelSteps; ++f) {
    for (int i = 0; i < kLanes; ++i)
      table.words[f][i] = static_cast<std::uint16_t>(i < 4 ? kTexelSteps - f : f);
  }
  return table;
}
constexpr Weights down_weights() {
  Weights table{};
  for (int f = 0; f < kTexelSteps; ++f) {
    for (int i = 0; i < kLanes; ++i) table.words[f][i] = static_cast<std::uint16_t>(f);
  }
  return table;
}
inline constexpr Weights kAcross = across_weights();
inline constexpr Weights kDown = down_weights();

inline Words pair_of_texels(const std::uint32_t* first, const std::uint32_t* second) {
  Bytes bytes;
  std::memcpy(&bytes, first, 8);
  std::memcpy(reinterpret_cast<char*>(&bytes) + 8, second, 8);
  return __builtin_convertvector(bytes, Words);
}

inline Words weights(const Weights& table, int first, int second) {
  Words w;
  std::memcpy(&w, table.words[first], 16);
  std::memcpy(reinterpret_cast<char*>(&w) + 16, table.words[second], 16);
  return w;
}

}  // namespace sampling

/// r, g, b and alpha as in Texture, rounded.
inline void sample(const SamplePoints& points, std::uint32_t* out) {
  using namespace sampling;
  for (int i = 0; i < kLanes; i += 2) {
    const std::uint32_t* const first = points.texel[i];
    const std::uint32_t* const second = points.texel[i + 1];
    const Words upper = pair_of_texels(first, second);
    const Words lower = pair_of_texels(first + points.row[i], second + points.row[i + 1]);
    const Words down = weights(kDown, points.down[i], points.down[i + 1]);
    const Words across = weights(kAcross, points.across[i], points.across[i + 1]);
    // At most 255 * 16 * 16, which 16 bits hold.
    const Words weighted = (upper * (kTexelSteps - down) + lower * down) * across;
    const Words other =
        __builtin_shufflevector(weighted, weighted, 4, 5, 6, 7, 4, 5, 6, 7, 12, 13, 14, 15, 12, 13, 14, 15);
    const Words rounded = (weighted + other + 128) >> 8;
    const Bytes bytes = __builtin_convertvector(rounded, Bytes);
    std::memcpy(out + i, &bytes, 4);
    std::memcpy(out + i + 1, reinterpret_cast<const char*>(&bytes) + 8, 4);
  }
}

}  // namespace copresence::renderer
