#include "common/depth/mask/mask_planes.h"

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include <algorithm>
#include <cstring>

namespace copresence::depth {
namespace {

static_assert(static_cast<int>(DepthState::kHole) == 0 && static_cast<int>(DepthState::kMeasured) == 1 &&
              static_cast<int>(DepthState::kFilled) == 2);

// Up to 64 states (bytes of 0, 1 or 2) to as many bits of each plane, and back.
struct Bits {
  std::uint64_t measured, filled;
};

constexpr std::uint64_t kLowBits = 0x0101010101010101u;

Bits gather_states(const std::uint8_t* states, int count) {
  Bits bits{0, 0};
  int i = 0;
#ifdef __AVX2__
  for (; i + 32 <= count; i += 32) {
    const __m256i bytes = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(states + i));
    const auto top_bits = [](__m256i v) {
      return std::uint64_t{static_cast<std::uint32_t>(_mm256_movemask_epi8(v))};
    };
    bits.measured |= top_bits(_mm256_slli_epi16(bytes, 7)) << i;
    bits.filled |= top_bits(_mm256_slli_epi16(bytes, 6)) << i;
  }
#endif
  for (; i < count; i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, states + i, static_cast<std::size_t>(std::min(8, count - i)));
    // A multiplication gathers the lowest bits of eight bytes.
    bits.measured |= ((eight & kLowBits) * 0x0102040810204080u >> 56) << i;
    bits.filled |= ((eight >> 1 & kLowBits) * 0x0102040810204080u >> 56) << i;
  }
  return bits;
}

void spread_states(Bits bits, std::uint8_t* states, int count) {
  int i = 0;
#ifdef __AVX2__
  const __m256i byte_of_bit = _mm256_setr_epi64x(0, kLowBits, 2 * kLowBits, 3 * kLowBits);
  const __m256i bit = _mm256_set1_epi64x(static_cast<std::int64_t>(0x8040201008040201u));
  const auto spread = [&](std::uint64_t plane) {  // a byte of all ones for every bit that is set
    const __m256i all = _mm256_set1_epi32(static_cast<std::int32_t>(plane));
    return _mm256_cmpeq_epi8(_mm256_and_si256(_mm256_shuffle_epi8(all, byte_of_bit), bit), bit);
  };
  for (; i + 32 <= count; i += 32) {
    const __m256i measured = _mm256_and_si256(spread(bits.measured >> i), _mm256_set1_epi8(1));
    const __m256i filled = _mm256_and_si256(spread(bits.filled >> i), _mm256_set1_epi8(2));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(states + i), _mm256_or_si256(measured, filled));
  }
#endif
  for (; i < count; ++i)
    states[i] = static_cast<std::uint8_t>((bits.measured >> i & 1) | (bits.filled >> i & 1) << 1);
}

}  // namespace

bool pack(const StateImage& states, MaskPlanes& planes) {
  std::uint64_t any_filled = 0;
  for (int y = 0; y < states.height(); ++y) {
    const auto* from = reinterpret_cast<const std::uint8_t*>(states.row(y).data());
    for (int x = 0; x < states.width(); x += 64) {
      const Bits bits = gather_states(from + x, std::min(64, states.width() - x));
      planes.measured.row(y)[x >> 6] = bits.measured;
      planes.filled.row(y)[x >> 6] = bits.filled;
      any_filled |= bits.filled;
    }
  }
  return any_filled != 0;
}

void unpack(const MaskPlanes& planes, StateImage& states) {
  for (int y = 0; y < states.height(); ++y) {
    auto* const to = reinterpret_cast<std::uint8_t*>(states.row(y).data());
    for (int x = 0; x < states.width(); x += 64) {
      spread_states({planes.measured.row(y)[x >> 6], planes.filled.row(y)[x >> 6]}, to + x,
                    std::min(64, states.width() - x));
    }
  }
}

}  // namespace copresence::depth
