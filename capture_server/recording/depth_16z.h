#pragma once

// OpenNI's lossless depth codings: "16zT" with an embedded table, and the older "16zP" without.
//
//   16zT:  u16 n   n x u16 the frame's distinct depths, ascending   u16 table index of pixel 0
//   16zP:  u16 depth of pixel 0
//   then, for each further pixel, d = previous index - this index (16zP: depths instead of indices):
//     |d| <= 6        the nibble d + 6, two to a byte, the first in the high half
//     7 <= |d| <= 63  escape, byte d + 192
//     larger          escape, high byte of the index or depth (below 0x80), low byte
//   The escape is 0xFF, or 0xF in the low half if a nibble is pending. Runs of the byte 0x66 (two
//   pixels equal to the previous one) are written as 0xE1 to 0xEF for 1 to 15 of them. A pending
//   nibble at the end is closed with 0xD.
//
// Thread: free functions on values, safe anywhere.

#include <cstdint>
#include <span>
#include <vector>

#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::recording {

/// Appends the frame as 16zT to `bytes`. Requires at least one pixel.
/// Fails  kUnsupported if the frame holds more than 32767 distinct values, which the coding cannot
///        number.
Result<void> append_depth_16z(const DepthImage& depth, std::vector<std::uint8_t>& bytes);

/// Whether the differences are between table indices (16zT) or between the depths themselves
/// (16zP).
enum class DepthTable { kEmbedded, kNone };

/// The inverse, for both codings: fills `depth`, whose size the caller sets, from untrusted bytes.
/// Fails  kCorrupt if they do not hold exactly that many pixels; `depth` is then unspecified.
Result<void> expand_depth_16z(std::span<const std::uint8_t> bytes, DepthTable table, DepthImage& depth);

}  // namespace copresence::recording
