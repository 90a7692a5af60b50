#pragma once

// RVL, a lossless depth codec, implemented from the description in the paper.
// Source: Andrew D. Wilson, Fast Lossless Depth Image Compression, ISS 2017.
// Runs of holes and runs of depth alternate. A pair of runs is coded as the number of zeros, the
// number of non-zeros, and the differences between consecutive non-zeros, zigzag-coded. Numbers
// consist of nibbles, the lowest first: three bits of value and one bit that is set if another
// nibble follows. Eight nibbles form a 32-bit word, with the first nibble in the highest bits.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::depth_bench {

std::vector<std::uint8_t> encode_rvl(std::span<const std::uint16_t> depth);
/// Requires the output of encode_rvl() for the same number of pixels.
void decode_rvl(std::span<const std::uint8_t> bytes, std::span<std::uint16_t> depth);

}  // namespace copresence::depth_bench
