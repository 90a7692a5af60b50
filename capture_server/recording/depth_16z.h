#pragma once

// "16zT", OpenNI's lossless depth coding with an embedded table.
//
//   u16 n   n x u16 the frame's distinct values, ascending   u16 table index of pixel 0
//   then per pixel d = index of the pixel before - this pixel's index:
//     |d| <= 6        the nibble d + 6, two to a byte, the first in the high half
//     7 <= |d| <= 63  escape, byte d + 192
//     larger          escape, index high byte (below 0x80), index low byte
//   The escape is 0xFF, or 0xF in the low half when a nibble is pending. Runs of the byte 0x66 (two pixels
//   like the one before) are written 0xE1 to 0xEF for 1 to 15 of them. A pending nibble at the end is closed
//   with 0xD.
//
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

/// Appends the coded frame to `bytes`. Requires at least one pixel.
/// Fails  kUnsupported when the frame holds more than 32767 distinct values, which the coding cannot number.
Result<void> append_depth_16z(const DepthImage& depth, std::vector<std::uint8_t>& bytes);

/// The inverse: fills `depth`, whose size the caller sets, from hostile bytes.
/// Fails  kCorrupt when they do not hold exactly that many pixels; `depth` is then unspecified.
Result<void> expand_depth_16z(std::span<const std::uint8_t> bytes, DepthImage& depth);

}  // namespace copresence::recording
