#pragma once

// Adaptive distribution over sixteen symbols, for ANS coding (ans_coder.h). The distribution
// consists of sixteen cumulative frequencies. A few vector instructions move all frequencies
// towards each coded symbol. Every symbol keeps a frequency of at least 1 of 16384. Thread: a
// value.

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <array>
#include <bit>
#include <cstdint>

namespace copresence::depth {

class AdaptiveCdf {
 public:
  static constexpr int kSymbols = 16;
  static constexpr int kBits = 14;  ///< Frequencies sum to 2^kBits.

  struct Slot {
    std::uint32_t start, frequency;
  };

  constexpr AdaptiveCdf() {
    for (int i = 0; i < kSymbols; ++i) start_[i] = static_cast<std::int16_t>(i * (kLearnt / kSymbols) + i);
  }

  /// Requires symbol < kSymbols.
  Slot slot(unsigned symbol) const {
    // The end of the last slot is 2^kBits, which the mask maps to 0.
    const std::uint32_t start = start_[symbol], end = start_[(symbol + 1) % kSymbols];
    return {start, (end - start) & ((1u << kBits) - 1)};
  }

  /// Returns the symbol whose slot holds `point`. Requires point < 2^kBits.
  unsigned symbol_at(std::uint32_t point) const {
#ifdef __SSE2__  // Every x86-64 machine has SSE2.
    const __m128i limit = _mm_set1_epi16(static_cast<std::int16_t>(point));
    const __m128i beyond =
        _mm_packs_epi16(_mm_cmpgt_epi16(eight(start_, 0), limit), _mm_cmpgt_epi16(eight(start_, 1), limit));
    const auto bits = static_cast<unsigned>(_mm_movemask_epi8(beyond));
    return static_cast<unsigned>(std::countr_zero(bits | 1u << kSymbols)) - 1;
#else
    unsigned symbol = 0;
    for (unsigned i = 1; i < kSymbols; ++i) symbol += static_cast<std::uint32_t>(start_[i]) <= point;
    return symbol;
#endif
  }

  void learn(unsigned symbol) {
    const Row& target = kTarget[symbol];
#ifdef __SSE2__
    for (int half = 0; half < 2; ++half) {
      const __m128i start = eight(start_, half);
      const __m128i step = _mm_srai_epi16(_mm_sub_epi16(eight(target, half), start), kRate);
      _mm_store_si128(reinterpret_cast<__m128i*>(start_.data()) + half, _mm_add_epi16(start, step));
    }
#else
    for (int i = 0; i < kSymbols; ++i) {
      start_[i] = static_cast<std::int16_t>(start_[i] + ((target[i] - start_[i]) >> kRate));
    }
#endif
  }

 private:
  using Row = std::array<std::int16_t, kSymbols>;
  static constexpr int kLearnt = (1 << kBits) - kSymbols;  // Total frequency minus 1 for each symbol.
  // The rate is 1/32. A rate of 1/64 saves 1 % of the bits, but learns slowly after a keyframe.
  static constexpr int kRate = 5;

  static constexpr std::array<Row, kSymbols> make_targets() {
    std::array<Row, kSymbols> targets{};
    for (int symbol = 0; symbol < kSymbols; ++symbol) {
      for (int i = 0; i < kSymbols; ++i)
        targets[symbol][i] = static_cast<std::int16_t>(i + (i > symbol ? kLearnt : 0));
    }
    return targets;
  }

#ifdef __SSE2__
  static __m128i eight(const Row& row, int half) {
    return _mm_load_si128(reinterpret_cast<const __m128i*>(row.data()) + half);
  }
#endif

  alignas(32) static const std::array<Row, kSymbols> kTarget;

  alignas(32) Row start_{};  // Cumulative frequency below each symbol, ascending.
};

alignas(32) inline constexpr std::array<AdaptiveCdf::Row, AdaptiveCdf::kSymbols> AdaptiveCdf::kTarget =
    make_targets();

}  // namespace copresence::depth
