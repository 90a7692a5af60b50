#pragma once

// The functions that the page's workers call. Each worker has its own instance of the WebAssembly
// module, so the exported functions may keep state. web/page/native.ts calls them.
//
// Arguments in bytes are written to the memory of reserve_input() first. A function returns 1 on
// success and 0 on failure. Then result_at() and result_bytes() give its result, a JSON object, or
// the sentence of the error. The result is valid until the next call. Times are in microseconds.

#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "common/frame/rgbd_frame.h"
#include "common/result.h"
#include "web/native/json_object.h"

#define COPRESENCE_EXPORT(name) extern "C" __attribute__((export_name(#name), used))

namespace copresence::web {

/// The first `bytes` bytes of the input. Requires that as many were reserved.
std::span<const std::uint8_t> input(std::uint32_t bytes);

/// Set the result. Both return what the exported function returns.
int succeed(const JsonObject& object);
int succeed(std::span<const std::uint8_t> bytes);
int fail_with(const Error& error);

inline double microseconds(Duration duration) {
  return std::chrono::duration<double, std::micro>(duration).count();
}
inline double microseconds(Instant instant) {
  return microseconds(instant.time_since_epoch());
}
inline Instant instant_of(double microseconds) {
  return Instant(
      std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(microseconds)));
}

}  // namespace copresence::web
