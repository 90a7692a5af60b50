#pragma once

// Bilinear samples of a Texture, eight at a time. Private to the CPU renderer. Thread: pure.

#include <cstdint>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/projection.h"
#include "render_client/renderer/source_texture.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

namespace sampling {

using Bytes = std::uint8_t __attribute__((vector_size(16)));
using Words = std::uint16_t __attribute__((vector_size(16)));
using WidePair = std::uint16_t __attribute__((vector_size(32)));
using Longs = std::uint64_t __attribute__((vector_size(16)));

inline constexpr int kFractionBits = 4;
static_assert(1 << kFractionBits == kTexelSteps);

struct Weights {
  alignas(16) std::uint16_t words[kTexelSteps][8];
};
/// Four channels of the left texel, then four of the right one.
inline constexpr Weights kAcross = [] {
  Weights table{};
  for (int f = 0; f < kTexelSteps; ++f) {
    for (int i = 0; i < 8; ++i) table.words[f][i] = static_cast<std::uint16_t>(i < 4 ? kTexelSteps - f : f);
  }
  return table;
}();
/// Of the lower texels.
inline constexpr Weights kDown = [] {
  Weights table{};
  for (int f = 0; f < kTexelSteps; ++f) {
    for (int i = 0; i < 8; ++i) table.words[f][i] = static_cast<std::uint16_t>(f);
  }
  return table;
}();

/// Two neighbouring texels from either address, a channel in 16 bits.
inline WidePair texels(const std::uint32_t* first, const std::uint32_t* second) {
  Longs both{};
  std::uint64_t half;
  std::memcpy(&half, first, sizeof half);
  both[0] = half;
  std::memcpy(&half, second, sizeof half);
  both[1] = half;
  return __builtin_convertvector(reinterpret_cast<Bytes>(both), WidePair);
}

inline WidePair weights(const Weights& table, int first, int second) {
  Words a, b;
  std::memcpy(&a, table.words[first], sizeof a);
  std::memcpy(&b, table.words[second], sizeof b);
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
}

/// Words 0 to 3 and 8 to 11 are the two colours.
inline WidePair sample_two(const std::uint32_t* first, const std::uint32_t* second, std::ptrdiff_t row,
                           std::int32_t across_first, std::int32_t across_second, std::int32_t down_first,
                           std::int32_t down_second) {
  const WidePair upper = texels(first, second);
  const WidePair lower = texels(first + row, second + row);
  const WidePair down = weights(kDown, down_first, down_second);
  // At most 255 * 16 * 16, which 16 bits hold, with 128 more for rounding.
  const WidePair weighted =
      (upper * (kTexelSteps - down) + lower * down) * weights(kAcross, across_first, across_second);
  const WidePair right =
      __builtin_shufflevector(weighted, weighted, 4, 5, 6, 7, 4, 5, 6, 7, 12, 13, 14, 15, 12, 13, 14, 15);
  return (weighted + right + 128) >> 8;
}

}  // namespace sampling

/// What a texture shows at eight texture coordinates (Band::texels), in Texture's layout, rounded.
inline Ints sample(const Texture& texture, const Ints& texel) {
  using namespace sampling;
  const Ints u = texel & 0xFFFF;
  const Ints v = texel >> 16 & 0xFFFF;
  alignas(32) std::int32_t at[kLanes], across[kLanes], down[kLanes];
  store(at, (v >> kFractionBits) * texture.width() + (u >> kFractionBits));
  store(across, u & (kTexelSteps - 1));
  store(down, v & (kTexelSteps - 1));
  const auto pair = [&](int i) {
    return sample_two(texture.data() + at[i], texture.data() + at[i + 1], texture.width(), across[i],
                      across[i + 1], down[i], down[i + 1]);
  };
  const auto four = [&](int i) {
    const WidePair colors = __builtin_shufflevector(pair(i), pair(i + 2), 0, 1, 2, 3, 8, 9, 10, 11, 16, 17,
                                                    18, 19, 24, 25, 26, 27);
    return __builtin_convertvector(colors, Bytes);
  };
  const Bytes low = four(0), high = four(4);
  Ints result;
  std::memcpy(&result, &low, sizeof low);
  std::memcpy(reinterpret_cast<char*>(&result) + sizeof low, &high, sizeof high);
  return result;
}

/// The texel nearest to each texture coordinate.
inline Ints nearest_texels(const Texture& texture, const Ints& texel) {
  using namespace sampling;
  const Ints u = ((texel & 0xFFFF) + kTexelSteps / 2) >> kFractionBits;
  const Ints v = ((texel >> 16 & 0xFFFF) + kTexelSteps / 2) >> kFractionBits;
  return gather(texture.data(), v * texture.width() + u);
}

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
