#pragma once

// Bilinear samples of a Texture, eight at a time, in whole numbers: the portable path gives the same bits as
// AVX2's. Private to the CPU renderer. Thread: pure.

#include <cstdint>
#include <cstring>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/projection.h"
#include "render_client/renderer/source_texture.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

inline constexpr int kTexelBits = 4;
static_assert(1 << kTexelBits == kTexelSteps);

/// The four texels around each of eight texture coordinates, and where between them each lies.
struct Texels {
  Ints upper_left, upper_right, lower_left, lower_right;
  Ints right, lower;  // of the upper left one, in 1/kTexelSteps, 0 <= right, lower < kTexelSteps
};

/// The texels at eight texture coordinates (Band::texels).
inline Texels fetch(const Texture& texture, const Ints& texel) {
  Texels t;
  const Ints u = texel & 0xFFFF;
  const Ints v = texel >> 16 & 0xFFFF;
  t.right = u & (kTexelSteps - 1);
  t.lower = v & (kTexelSteps - 1);
  const Ints at = (v >> kTexelBits) * texture.width() + (u >> kTexelBits);
  const std::uint32_t* const upper = texture.data();
  const std::uint32_t* const lower = texture.data() + texture.width();
#if defined(__AVX2__)
  // Two neighbouring texels at once, since a gather of single ones takes longer: of lanes 0, 1, 4, 5 and of 2, 3, 6, 7.
  const auto pairs = [&](const std::uint32_t* row, Ints& left, Ints& right) {
    const auto pair = [&](int i) {
      long long two;
      std::memcpy(&two, row + at[i], sizeof two);
      return two;
    };
    const __m256 some = _mm256_castsi256_ps(_mm256_set_epi64x(pair(5), pair(4), pair(1), pair(0)));
    const __m256 others = _mm256_castsi256_ps(_mm256_set_epi64x(pair(7), pair(6), pair(3), pair(2)));
    left = reinterpret_cast<Ints>(_mm256_shuffle_ps(some, others, 0x88));
    right = reinterpret_cast<Ints>(_mm256_shuffle_ps(some, others, 0xDD));
  };
  pairs(upper, t.upper_left, t.upper_right);
  pairs(lower, t.lower_left, t.lower_right);
#else
  t.upper_left = gather(upper, at);
  t.upper_right = gather(upper + 1, at);
  t.lower_left = gather(lower, at);
  t.lower_right = gather(lower + 1, at);
#endif
  return t;
}

/// The texel nearest to each texture coordinate.
inline Ints nearest(const Texels& t) {
  const Ints is_right = t.right >= kTexelSteps / 2;
  const Ints upper = is_right ? t.upper_right : t.upper_left;
  const Ints lower = is_right ? t.lower_right : t.lower_left;
  return t.lower >= kTexelSteps / 2 ? lower : upper;
}

/// What the texture shows, in Texture's layout, rounded.
inline Ints bilinear(const Texels& t) {
  using Words = std::uint16_t __attribute__((vector_size(sizeof(Ints))));
  const auto words = [](const Ints& i) { return reinterpret_cast<Words>(i); };
  const Words right = words(t.right | t.right << 16), lower = words(t.lower | t.lower << 16);
  const Words left = kTexelSteps - right, upper = kTexelSteps - lower;
  // Two channels of each texel side by side. At most 255 * 16, then 255 * 16 * 16, which a word holds.
  const auto two_channels = [&](int shift) {
    const auto channels = [&](const Ints& texels) { return words(texels >> shift & 0x00FF00FF); };
    const Words left_column = channels(t.upper_left) * upper + channels(t.lower_left) * lower;
    const Words right_column = channels(t.upper_right) * upper + channels(t.lower_right) * lower;
    return reinterpret_cast<Ints>((left_column * left + right_column * right + 128) >> 2 * kTexelBits);
  };
  return two_channels(0) | two_channels(8) << 8;
}

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
