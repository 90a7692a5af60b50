#pragma once

// RVL: Andrew D. Wilson, "Fast Lossless Depth Image Compression", ISS 2017, from the paper's description.
//
// Runs of holes and of depth alternate: a number of zeros, a number of non-zeros, then for each of these the difference to the
// depth before, zigzag. Numbers are written in nibbles, three bits of value and one that says whether more follow, lowest
// first, eight nibbles to a 32-bit word, first nibble highest.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"

namespace copresence::depth_bench {

std::vector<std::uint8_t> encode_rvl(std::span<const std::uint16_t> depth);
/// Requires what encode_rvl made of as many pixels.
void decode_rvl(std::span<const std::uint8_t> bytes, std::span<std::uint16_t> depth);

}  // namespace copresence::depth_bench
