#pragma once

// Eight numbers at a time, in the compiler's own vector types: AVX2 where the build has it, two SSE halves
// where it does not, with the same results, since every lane is plain IEEE arithmetic. Private to the CPU
// renderer.

#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Everything here is inlined, so that no call's ABI depends on the instruction set.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

inline constexpr int kLanes = 8;

using Floats = float __attribute__((vector_size(kLanes * 4)));
using Ints = std::int32_t __attribute__((vector_size(kLanes * 4)));

inline Floats all(float value) {
  return Floats{} + value;
}
inline Ints all(std::int32_t value) {
  return Ints{} + value;
}

/// 0, 1, ..., 7
inline Floats ramp() {
  return Floats{0, 1, 2, 3, 4, 5, 6, 7};
}

template <class Vector, class Scalar>
Vector load(const Scalar* from) {
  static_assert(sizeof(Scalar) * kLanes == sizeof(Vector));
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

template <class Vector, class Scalar>
void store(Scalar* to, const Vector& v) {
  static_assert(sizeof(Scalar) * kLanes == sizeof(Vector));
  std::memcpy(to, &v, sizeof v);
}

inline Ints truncated(const Floats& v) {
  return __builtin_convertvector(v, Ints);
}
inline Floats as_floats(const Ints& v) {
  return __builtin_convertvector(v, Floats);
}

inline Floats smaller(const Floats& a, const Floats& b) {
  return a < b ? a : b;
}
inline Floats larger(const Floats& a, const Floats& b) {
  return a > b ? a : b;
}

/// One bit per lane of a comparison's result.
inline unsigned bits(const Ints& mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(reinterpret_cast<__m256i>(mask))));
#else
  unsigned result = 0;
  for (int lane = 0; lane < kLanes; ++lane) result |= (mask[lane] ? 1U : 0U) << lane;
  return result;
#endif
}

/// from[index[0]], from[index[1]], ...
inline Ints gather(const std::uint32_t* from, const Ints& index) {
#if defined(__AVX2__)
  return reinterpret_cast<Ints>(
      _mm256_i32gather_epi32(reinterpret_cast<const int*>(from), reinterpret_cast<__m256i>(index), 4));
#else
  Ints result{};
  for (int lane = 0; lane < kLanes; ++lane) result[lane] = static_cast<std::int32_t>(from[index[lane]]);
  return result;
#endif
}

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
