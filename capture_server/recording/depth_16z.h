#pragma once

// OpenNI's lossless depth codings: "16zT" with an embedded table, and the older "16zP" without it.
//
//   `16zT`: u16 n, n u16 with the frame's distinct depths, ascending, u16 table index of pixel 0.
//   `16zP`: u16 depth of pixel 0.
//   Then, for each further pixel, d = previous index - this index (16zP: depths, not indices).
//     `|d| <= 6`: the nibble d + 6, two to a byte, the first in the high half.
//     `7 <= |d| <= 63`: an escape, then the byte d + 192.
//     Larger: an escape, the high byte of the index or depth (below 0x80), then the low byte.
//   The escape is the byte 0xFF, or the nibble 0xF if the low half of a byte comes next.
//   The byte 0x66 (two pixels equal to the previous one) is run-length coded: 0xE1 to 0xEF stand for
//   1 to 15 of it. If the last byte lacks its low half, that half is 0xD.
//
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

/// Appends the frame as 16zT to `bytes`. Requires at least one pixel.
/// Fails with kUnsupported on more than 32767 distinct depths, because a table index has 15 bits.
Result<void> append_depth_16z(const DepthImage& depth, std::vector<std::uint8_t>& bytes);

/// Differences are between table indices (kEmbedded, 16zT) or between depths (kNone, 16zP).
enum class DepthTable { kEmbedded, kNone };

/// Decodes both codings from untrusted bytes into `depth`, whose size the caller sets.
/// Fails with kCorrupt if the bytes do not hold exactly that many pixels.
Result<void> expand_depth_16z(std::span<const std::uint8_t> bytes, DepthTable table, DepthImage& depth);

}  // namespace copresence::recording
