#pragma once

// Samples a CameraTexture at eight positions at a time, in integer arithmetic. The portable code
// and the AVX2 code give identical results. Thread: pure functions.

#include <array>
#include <cstdint>
#include <cstring>

#include "render_client/renderer/cpu/camera_texture.h"
#include "render_client/renderer/cpu/lanes.h"
#include "render_client/renderer/cpu/projection.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

inline constexpr int kTexelBits = 4;
static_assert(1 << kTexelBits == kTexelSteps);

/// Requires a texture of at most 32767 columns. The texture must outlive the sampler.
class TextureSampler {
 public:
  explicit TextureSampler(const CameraTexture& texture) : texels_(texture.data()), width_(texture.width()) {}

  /// Returns the texels at eight coordinates in the format of Tile::texels(). Red, green and blue
  /// are bilinear and rounded. Alpha is that of the nearest texel.
  Ints at(const Ints& coordinates) const;

 private:
  const std::uint32_t* texels_;
  int width_;
};

[[gnu::always_inline]] inline Ints TextureSampler::at(const Ints& coordinates) const {
  const std::uint32_t* const upper_row = texels_;
  const std::uint32_t* const lower_row = texels_ + width_;
#if defined(__AVX2__)
  const auto words = reinterpret_cast<__m256i>(coordinates);
  // The index is v * width + u, with u and v in whole texels.
  const __m256i whole = _mm256_srli_epi16(words, kTexelBits);
  const __m256i indices = _mm256_madd_epi16(whole, _mm256_set1_epi32(width_ << 16 | 1));
  const __m128i at_0123 = _mm256_castsi256_si128(indices), at_4567 = _mm256_extracti128_si256(indices, 1);
  const std::array<std::uint64_t, 4> two = {static_cast<std::uint64_t>(_mm_cvtsi128_si64(at_0123)),
                                            static_cast<std::uint64_t>(_mm_extract_epi64(at_0123, 1)),
                                            static_cast<std::uint64_t>(_mm_cvtsi128_si64(at_4567)),
                                            static_cast<std::uint64_t>(_mm_extract_epi64(at_4567, 1))};
  // Loads a texel and its right neighbour for pixels first, first + 1, first + 4 and first + 5.
  // Each pair is broadcast and then blended. Shuffles would be slower, because the only execution
  // port for them is busy below.
  const auto pairs = [](const std::uint32_t* row, std::uint64_t low, std::uint64_t high) {
    const auto pair = [row](std::uint64_t index) {
      long long texels;
      std::memcpy(&texels, row + index, sizeof texels);
      return _mm256_set1_epi64x(texels);
    };
    return _mm256_blend_epi32(_mm256_blend_epi32(pair(low & 0xFFFFFFFF), pair(low >> 32), 0x0C),
                              _mm256_blend_epi32(pair(high & 0xFFFFFFFF), pair(high >> 32), 0xC0), 0xF0);
  };
  // Interleaves the bytes of two texels, so that equal channels lie side by side.
  const __m256i side_by_side =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15));
  // `across` has the weights of the left and the right texel, `down` that of the lower row. Red,
  // green and blue are interpolated, but alpha is taken from one texel.
  const __m256i fraction = _mm256_and_si256(words, _mm256_set1_epi16(kTexelSteps - 1));
  const __m256i rounded = _mm256_and_si256(_mm256_slli_epi16(fraction, 1), _mm256_set1_epi16(kTexelSteps));
  const __m256i right = _mm256_blend_epi16(fraction, _mm256_slli_epi32(rounded, 16), 0xAA);
  const __m256i across =
      _mm256_or_si256(_mm256_sub_epi16(_mm256_set1_epi16(kTexelSteps), right), _mm256_slli_epi16(right, 8));
  const __m256i down = _mm256_blend_epi16(_mm256_srli_epi32(fraction, 16), rounded, 0xAA);
  const auto spread = [](const __m256i& weights, int first) {
    // The low word of a pixel is the weight of red, green and blue, the high word that of alpha.
    const int f = 4 * first, s = 4 * first + 4;
    const __m128i order = _mm_setr_epi8(char(f), char(f + 1), char(f), char(f + 1), char(f), char(f + 1),
                                        char(f + 2), char(f + 3), char(s), char(s + 1), char(s), char(s + 1),
                                        char(s), char(s + 1), char(s + 2), char(s + 3));
    return _mm256_shuffle_epi8(weights, _mm256_broadcastsi128_si256(order));
  };
  // Blends pixels first, first + 1, first + 4 and first + 5, in 16 bits per channel.
  const auto blend = [&](int first) {
    const std::uint64_t low = two[first / 2], high = two[2 + first / 2];
    const __m256i columns = spread(across, first), lower_share = spread(down, first);
    const auto row = [&](const std::uint32_t* texels) {
      return _mm256_maddubs_epi16(_mm256_shuffle_epi8(pairs(texels, low, high), side_by_side), columns);
    };
    // The difference may be negative. The sum is correct, since all arithmetic is modulo 2^16.
    const __m256i upper = row(upper_row), difference = _mm256_sub_epi16(row(lower_row), upper);
    const __m256i sum =
        _mm256_add_epi16(_mm256_slli_epi16(upper, kTexelBits), _mm256_mullo_epi16(difference, lower_share));
    return _mm256_srli_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(128)), 2 * kTexelBits);
  };
  return reinterpret_cast<Ints>(_mm256_packus_epi16(blend(0), blend(2)));
#else
  Ints result{};
  for (int lane = 0; lane < kLanes; ++lane) {
    const int u = coordinates[lane] & 0xFFFF, v = coordinates[lane] >> 16 & 0xFFFF;
    const int at = (v >> kTexelBits) * width_ + (u >> kTexelBits);
    const int right = u & (kTexelSteps - 1), lower = v & (kTexelSteps - 1);
    const auto blended = [&](int channel, int to_right, int to_lower) {
      const auto texel = [&](const std::uint32_t* row, int x) {
        return static_cast<int>(row[at + x] >> 8 * channel & 0xFF);
      };
      const auto row = [&](const std::uint32_t* texels) {
        return texel(texels, 0) * (kTexelSteps - to_right) + texel(texels, 1) * to_right;
      };
      return (row(upper_row) * (kTexelSteps - to_lower) + row(lower_row) * to_lower + 128) >> 2 * kTexelBits;
    };
    const auto nearest = [](int fraction) { return fraction >= kTexelSteps / 2 ? kTexelSteps : 0; };
    for (int channel = 0; channel < 3; ++channel)
      result[lane] |= blended(channel, right, lower) << 8 * channel;
    result[lane] |= static_cast<std::int32_t>(
        static_cast<std::uint32_t>(blended(3, nearest(right), nearest(lower))) << 24);
  }
  return result;
#endif
}

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
