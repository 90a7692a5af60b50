#pragma once

// Table lookups between depth and codes for the monochrome codecs. A picture has only some hundred
// distinct values, so the used parts of the tables stay in the first-level cache. Thread: pure.

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "common/frame/image.h"
#include "common/frame/picture.h"

namespace copresence::depth {

/// Reads four 16-bit values as one number. The first value has the lowest bits.
inline std::uint64_t four_at(const std::uint16_t* in) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t four;
  std::memcpy(&four, in, sizeof(four));
  return four;
}

inline void look_up_four(const std::uint16_t* table, std::uint64_t four, std::uint16_t* out) {
  out[0] = table[four & 0xffff];
  out[1] = table[four >> 16 & 0xffff];
  out[2] = table[four >> 32 & 0xffff];
  out[3] = table[four >> 48];
}

/// Sets out[i] = table[in[i]]. Requires 65536 entries. Loads four values at a time; g++ compiles
/// the plain loop to code that takes twice as long.
inline void look_up(const std::uint16_t* table, const std::uint16_t* in, std::uint16_t* out,
                    std::size_t count) {
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) look_up_four(table, four_at(in + i), out + i);
  for (; i < count; ++i) out[i] = table[in[i]];
}

/// Sets picture = code_of_depth[depth]. Requires 65536 entries in range, and equal shapes.
inline void write_codes(std::span<const std::uint16_t> code_of_depth, const DepthImage& depth,
                        Picture& picture) {
  assert(code_of_depth.size() == 65536);
  const std::uint16_t* const table = code_of_depth.data();
  const std::span<const std::uint16_t> in = depth.pixels();
  if (picture.format() == PixelFormat::kGray10) {
    look_up(table, in.data(), picture.plane10().data(), in.size());
  } else {
    std::uint8_t* const out = picture.plane8(0).data();
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = static_cast<std::uint8_t>(table[in[i]]);
  }
}

/// Sets depth = depth_of_code[picture]. Samples beyond the table's end use its last entry. Requires
/// 256 entries for a picture of 8 bits, 1024 for 10 bits, and equal shapes.
inline void read_codes(std::span<const std::uint16_t> depth_of_code, const Picture& picture,
                       DepthImage& depth) {
  const std::uint16_t* const table = depth_of_code.data();
  const std::span<std::uint16_t> out = depth.pixels();
  if (picture.format() == PixelFormat::kGray10) {
    assert(depth_of_code.size() == 1024);
    constexpr std::uint64_t kBeyond = 0xfc00fc00fc00fc00u;  // These bits are 0 in all codes.
    const std::uint16_t* const in = picture.plane10().data();
    for (std::size_t i = 0; i < out.size();) {
      const bool four_left = i + 4 <= out.size();
      if (const std::uint64_t four = four_left ? four_at(in + i) : kBeyond; (four & kBeyond) == 0) {
        look_up_four(table, four, out.data() + i);
        i += 4;
      } else {
        out[i] = table[in[i] < 1024 ? in[i] : 1023];
        ++i;
      }
    }
  } else {
    assert(depth_of_code.size() == 256);
    const std::uint8_t* const in = picture.plane8(0).data();
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = table[in[i]];
  }
}

}  // namespace copresence::depth
