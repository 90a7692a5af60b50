#pragma once

// Functions of C++20's standard library that the libc++ of Debian 12's emscripten lacks. They are
// defined here so that the shared sources need no special cases. A newer libc++ uses its own.

#include <version>

#ifndef __cpp_lib_bit_cast
namespace std {
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  return __builtin_bit_cast(To, from);
}
}  // namespace std
#endif

#ifndef __cpp_lib_smart_ptr_for_overwrite
#include <cstddef>
#include <memory>
#include <type_traits>
namespace std {
template <class Array>
unique_ptr<Array> make_unique_for_overwrite(size_t size) {
  return unique_ptr<Array>(new remove_extent_t<Array>[size]);
}
}  // namespace std
#endif

#ifndef __cpp_lib_to_chars
#include <charconv>
#include <cstdlib>
#include <string>
namespace std {
// WebAssembly has only the locale "C", in which strtod() accepts the same numbers.
inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const string text(first, last);
  char* end = nullptr;
  const double number = strtod(text.c_str(), &end);
  if (end == text.c_str()) return {first, errc::invalid_argument};
  value = number;
  return {first + (end - text.c_str()), errc()};
}
}  // namespace std
#endif
