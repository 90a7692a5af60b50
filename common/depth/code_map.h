#pragma once

// Depth to codes and back by table, for the monochrome codecs. The tables stay in the first-level cache,
// since a picture holds only some hundred distinct values: a lookup per pixel is all there is to do.

#include <cassert>
#include <cstdint>
#include <span>

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::depth {

/// picture = code_of_depth[depth]. Requires 65536 entries that fit the picture's samples, and one shape.
inline void write_codes(std::span<const std::uint16_t> code_of_depth, const DepthImage& depth,
                        Picture& picture) {
  assert(code_of_depth.size() == 65536);
  const std::uint16_t* const table = code_of_depth.data();
  const std::span<const std::uint16_t> in = depth.pixels();
  if (picture.format() == PixelFormat::kGray10) {
    std::uint16_t* const out = picture.plane10().data();
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = table[in[i]];
  } else {
    std::uint8_t* const out = picture.plane8(0).data();
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = static_cast<std::uint8_t>(table[in[i]]);
  }
}

/// depth = depth_of_code[picture], samples beyond the table's end counting as its last.
/// Requires 256 entries for a picture of 8 bits, 1024 for one of 10, and one shape.
inline void read_codes(std::span<const std::uint16_t> depth_of_code, const Picture& picture,
                       DepthImage& depth) {
  const std::uint16_t* const table = depth_of_code.data();
  const std::span<std::uint16_t> out = depth.pixels();
  if (picture.format() == PixelFormat::kGray10) {
    assert(depth_of_code.size() == 1024);
    const std::uint16_t* const in = picture.plane10().data();
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = table[in[i] < 1024 ? in[i] : 1023];
  } else {
    assert(depth_of_code.size() == 256);
    const std::uint8_t* const in = picture.plane8(0).data();
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = table[in[i]];
  }
}

}  // namespace copresence::depth
