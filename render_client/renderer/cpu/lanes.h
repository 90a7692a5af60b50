#pragma once

// Vectors of eight numbers, in vector types of the compiler. They use AVX2 if the build allows it,
// and two SSE registers otherwise. Both give equal results, since every lane follows IEEE
// arithmetic. Thread: pure functions.

#include <cstddef>
#include <cstdint>
#include <cstring>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// All functions are inlined, because the ABI of a call would depend on the instruction set.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace copresence::renderer {

inline constexpr int kLanes = 8;

using Floats = float __attribute__((vector_size(kLanes * 4)));
using Ints = std::int32_t __attribute__((vector_size(kLanes * 4)));
using UnsignedInts = std::uint32_t __attribute__((vector_size(kLanes * 4)));
using Words = std::uint16_t __attribute__((vector_size(kLanes * 4)));  // Two per lane.

using Four = float __attribute__((vector_size(16)));
using FourInts = std::int32_t __attribute__((vector_size(16)));

inline Floats all(float value) {
  return Floats{} + value;
}
inline Ints all(std::int32_t value) {
  return Ints{} + value;
}

/// Returns 0, 1, ..., 7.
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
  std::memcpy(static_cast<void*>(to), &v, sizeof v);
}

/// Loads the first `count` lanes, and at most all. The others are 0.
template <class Vector, class Scalar>
Vector load_first(const Scalar* from, int count) {
  if (count >= kLanes) return load<Vector>(from);
  Vector v{};
  std::memcpy(&v, from, count * sizeof *from);
  return v;
}

/// Stores the first `count` lanes, and at most all.
template <class Vector, class Scalar>
void store_first(Scalar* to, const Vector& v, int count) {
  if (count >= kLanes) return store(to, v);
  std::memcpy(static_cast<void*>(to), &v, count * sizeof *to);
}

/// Loads lanes 0 to 3 from `from`, and lanes 4 to 7 from `from + second_half`.
template <class Vector, class Scalar>
Vector load_halves(const Scalar* from, std::ptrdiff_t second_half) {
  static_assert(sizeof(Scalar) * kLanes == sizeof(Vector));
  using Half = float __attribute__((vector_size(kLanes * 2)));
  Half low, high;
  std::memcpy(&low, from, sizeof low);
  std::memcpy(&high, from + second_half, sizeof high);
  return reinterpret_cast<Vector>(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7));
}

template <class Vector, class Scalar>
void store_halves(Scalar* to, std::ptrdiff_t second_half, const Vector& v) {
  static_assert(sizeof(Scalar) * kLanes == sizeof(Vector));
  const auto floats = reinterpret_cast<Floats>(v);
  const auto low = __builtin_shufflevector(floats, floats, 0, 1, 2, 3);
  const auto high = __builtin_shufflevector(floats, floats, 4, 5, 6, 7);
  std::memcpy(to, &low, sizeof low);
  std::memcpy(to + second_half, &high, sizeof high);
}

inline Ints truncated(const Floats& v) {
  return __builtin_convertvector(v, Ints);
}
inline Floats as_floats(const Ints& v) {
  return __builtin_convertvector(v, Floats);
}

template <class Vector>
Vector smaller(const Vector& a, const Vector& b) {
  return a < b ? a : b;
}
template <class Vector>
Vector larger(const Vector& a, const Vector& b) {
  return a > b ? a : b;
}

inline float sum(const Floats& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/// Returns one bit per lane of a comparison's result.
inline unsigned bits(const Ints& mask) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(reinterpret_cast<__m256i>(mask))));
#else
  unsigned result = 0;
  for (int lane = 0; lane < kLanes; ++lane) result |= (mask[lane] ? 1U : 0U) << lane;
  return result;
#endif
}

/// Returns from[index[0]], from[index[1]] and so on. The elements are loaded one by one, because
/// AVX2's gather instruction is slower on many processors.
inline Ints gather(const std::uint32_t* from, const Ints& index) {
  Ints result{};
  for (int lane = 0; lane < kLanes; ++lane) result[lane] = static_cast<std::int32_t>(from[index[lane]]);
  return result;
}

}  // namespace copresence::renderer

#pragma GCC diagnostic pop
