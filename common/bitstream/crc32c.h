#pragma once

// CRC-32C (Castagnoli): the check that makes a damaged access unit an error instead of a wrong depth.
// Source: RFC 3720, appendix B.4. Finds every burst of up to 32 bits, so every flipped bit and byte.
// Thread: pure.

#include <cstdint>
#include <span>

namespace copresence::bitstream {

/// Of `bytes`, or of a longer text of which `before` is the CRC so far.
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

}  // namespace copresence::bitstream
