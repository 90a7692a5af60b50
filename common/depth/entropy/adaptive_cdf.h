#pragma once

// A learnt distribution over sixteen symbols, for ANS coding (ans_coder.h): sixteen cumulative frequencies that move
// together towards what came, in a few vector instructions.
//
// Every symbol keeps a frequency of at least 1 of 16384, whatever was learnt. Thread: a value.

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include <array>
#include <bit>
#include <cstdint>

namespace copresence::depth {

class alignas(32) AdaptiveCdf {
 public:
  static constexpr int kSymbols = 16;
  static constexpr int kBits = 14;  ///< frequencies are of 2^kBits

  struct Slot {
    std::uint32_t start, frequency;
  };

  constexpr AdaptiveCdf() {
    for (int i = 0; i < kSymbols; ++i) start_[i] = static_cast<std::int16_t>(i * (kLearnt / kSymbols) + i);
  }

  /// Requires 0 <= symbol < kSymbols.
  Slot slot(unsigned symbol) const {
    const std::uint32_t start = start_[symbol];
    return {start, (start_[(symbol + 1) % kSymbols] - start) &
                       ((1u << kBits) - 1)};  // after the last comes 2^kBits, like 0
  }

  /// The symbol whose slot holds `point`. Requires point < 2^kBits.
  unsigned symbol_at(std::uint32_t point) const {
#ifdef __AVX2__
    const __m256i beyond =
        _mm256_cmpgt_epi16(load(start_), _mm256_set1_epi16(static_cast<std::int16_t>(point)));
    const auto bits = std::uint64_t{static_cast<std::uint32_t>(_mm256_movemask_epi8(beyond))};
    return static_cast<unsigned>(std::countr_zero(bits | std::uint64_t{1} << 32)) / 2 - 1;
#else
    unsigned symbol = 0;
    for (unsigned i = 1; i < kSymbols; ++i) symbol += static_cast<std::uint32_t>(start_[i]) <= point;
    return symbol;
#endif
  }

  void learn(unsigned symbol) {
#ifdef __AVX2__
    const __m256i start = load(start_);
    const __m256i step = _mm256_srai_epi16(_mm256_sub_epi16(load(kTarget[symbol]), start), kRate);
    _mm256_store_si256(reinterpret_cast<__m256i*>(start_.data()), _mm256_add_epi16(start, step));
#else
    for (int i = 0; i < kSymbols; ++i) {
      start_[i] = static_cast<std::int16_t>(start_[i] + ((kTarget[symbol][i] - start_[i]) >> kRate));
    }
#endif
  }

 private:
  using Row = std::array<std::int16_t, kSymbols>;
  static constexpr int kLearnt = (1 << kBits) - kSymbols;  // what is left when every symbol has its 1
  static constexpr int kRate =
      5;  // a symbol moves its distribution by 1/32; 1/64 saves 1 % and learns a keyframe later

  static constexpr std::array<Row, kSymbols> make_targets() {
    std::array<Row, kSymbols> targets{};
    for (int symbol = 0; symbol < kSymbols; ++symbol) {
      for (int i = 0; i < kSymbols; ++i)
        targets[symbol][i] = static_cast<std::int16_t>(i + (i > symbol ? kLearnt : 0));
    }
    return targets;
  }
#ifdef __AVX2__
  static __m256i load(const Row& row) {
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(row.data()));
  }
#endif

  alignas(32) static const std::array<Row, kSymbols> kTarget;

  Row start_{};  // the frequencies of all symbols below each; ascends
};

alignas(32) inline constexpr std::array<AdaptiveCdf::Row, AdaptiveCdf::kSymbols> AdaptiveCdf::kTarget =
    make_targets();

}  // namespace copresence::depth
