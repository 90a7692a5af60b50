#pragma once

// Bilinear samples of a Texture, eight at a time, in whole numbers: the portable path gives the same bits as
// AVX2's. Private to the CPU renderer. Thread: pure.

#include <cstdint>

#include "render_client/renderer/lanes.h"
#include "render_client/renderer/projection.h"
#include "render_client/renderer/source_texture.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

inline constexpr int kTexelBits = 4;
static_assert(1 << kTexelBits == kTexelSteps);

/// The texel nearest to each texture coordinate (Band::texels).
inline Ints nearest_texels(const Texture& texture, const Ints& texel) {
  const Ints u = ((texel & 0xFFFF) + kTexelSteps / 2) >> kTexelBits;
  const Ints v = ((texel >> 16 & 0xFFFF) + kTexelSteps / 2) >> kTexelBits;
  return gather(texture.data(), v * texture.width() + u);
}

#if defined(__AVX2__)

/// What a texture shows at eight texture coordinates, in Texture's layout, rounded.
inline Ints sample(const Texture& texture, const Ints& texel) {
  const Ints u = texel & 0xFFFF;
  const Ints v = texel >> 16 & 0xFFFF;
  const auto at = reinterpret_cast<__m256i>((v >> kTexelBits) * texture.width() + (u >> kTexelBits));
  const Ints right = u & (kTexelSteps - 1), lower = v & (kTexelSteps - 1);
  // Weights of left and right, upper and lower texels, as two bytes and as two words in each lane.
  const auto down = reinterpret_cast<__m256i>((kTexelSteps - lower) | lower << 8);
  const auto across = reinterpret_cast<__m256i>((kTexelSteps - right) | right << 16);

  // Colours of four pixels, a channel in 16 bits. `index` are their first texels; `first` tells which of a
  // half's four lanes have their weights.
  const auto four = [&](__m128i index, int first) {
    const auto* const upper_row = reinterpret_cast<const long long*>(texture.data());
    const auto* const lower_row = reinterpret_cast<const long long*>(texture.data() + texture.width());
    const __m256i above = _mm256_i32gather_epi64(upper_row, index, 4);
    const __m256i below = _mm256_i32gather_epi64(lower_row, index, 4);
    // The first and third pixel, then the second and fourth: left and right texel, a channel of both rows in
    // two bytes.
    const __m256i even = _mm256_unpacklo_epi8(above, below), odd = _mm256_unpackhi_epi8(above, below);
    const auto half = [&](const __m256i& weights) {
      return first == 0 ? _mm256_permute4x64_epi64(weights, 0x50) : _mm256_permute4x64_epi64(weights, 0xFA);
    };
    // Each half now has its two pixels' weights in lanes 0 and 1.
    const __m256i down_here = half(down), across_here = half(across);
    const auto bytes = [&](int lane) {
      return _mm256_shuffle_epi8(down_here, _mm256_set1_epi16(static_cast<short>(0x0100 + 0x0404 * lane)));
    };
    const auto words = [&](int lane) {
      const auto left = static_cast<long long>(0x0100010001000100 + 0x0404040404040404 * lane);
      const long long right_of_it = left + 0x0202020202020202;
      return _mm256_shuffle_epi8(across_here, _mm256_set_epi64x(right_of_it, left, right_of_it, left));
    };
    // At most 255 * 16, then 255 * 16 * 16, which 16 bits hold without a sign.
    const __m256i e = _mm256_mullo_epi16(_mm256_maddubs_epi16(even, bytes(0)), words(0));
    const __m256i o = _mm256_mullo_epi16(_mm256_maddubs_epi16(odd, bytes(1)), words(1));
    const __m256i sum = _mm256_add_epi16(_mm256_unpacklo_epi64(e, o), _mm256_unpackhi_epi64(e, o));
    return _mm256_srli_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(128)), 8);
  };
  const __m256i packed =
      _mm256_packus_epi16(four(_mm256_castsi256_si128(at), 0), four(_mm256_extracti128_si256(at, 1), 1));
  return reinterpret_cast<Ints>(_mm256_permute4x64_epi64(packed, 0xD8));
}

#else

inline Ints sample(const Texture& texture, const Ints& texel) {
  Ints result{};
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t u = static_cast<std::uint32_t>(texel[lane]) & 0xFFFF;
    const std::uint32_t v = static_cast<std::uint32_t>(texel[lane]) >> 16;
    const std::uint32_t right = u % kTexelSteps, lower = v % kTexelSteps;
    const std::uint32_t* const above =
        texture.data() + static_cast<std::ptrdiff_t>(v / kTexelSteps) * texture.width() + u / kTexelSteps;
    const std::uint32_t* const below = above + texture.width();
    std::uint32_t color = 0;
    for (int shift = 0; shift < 32; shift += 8) {
      const auto channel = [shift](std::uint32_t c) { return c >> shift & 0xFF; };
      const std::uint32_t left_column = channel(above[0]) * (kTexelSteps - lower) + channel(below[0]) * lower;
      const std::uint32_t right_column =
          channel(above[1]) * (kTexelSteps - lower) + channel(below[1]) * lower;
      color |= (left_column * (kTexelSteps - right) + right_column * right + 128) >> 8 << shift;
    }
    result[lane] = static_cast<std::int32_t>(color);
  }
  return result;
}

#endif

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
