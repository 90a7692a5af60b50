#pragma once

// The one function of zlib that the side data needs. Debian has no zlib for WebAssembly. Every bit
// is as in zlib, or no frame would pass its check. Source: RFC 1952, section 8. Thread: pure.

#include <array>
#include <cstddef>
#include <cstdint>

inline std::uint32_t crc32_z(std::uint32_t before, const std::uint8_t* bytes, std::size_t count) {
  // Table n has the effect of a byte that n more bytes follow, so that eight bytes need one step.
  static constexpr auto kTables = [] {
    std::array<std::array<std::uint32_t, 256>, 8> tables{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
      std::uint32_t crc = byte;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320U : 0);
      tables[0][byte] = crc;
    }
    for (std::size_t n = 1; n < tables.size(); ++n) {
      for (std::uint32_t byte = 0; byte < 256; ++byte) {
        const std::uint32_t shorter = tables[n - 1][byte];
        tables[n][byte] = shorter >> 8 ^ tables[0][shorter & 255];
      }
    }
    return tables;
  }();
  std::uint32_t crc = ~before;
  for (; count >= 8; count -= 8, bytes += 8) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      const std::uint32_t byte = i < 4 ? bytes[i] ^ (crc >> (8 * i) & 255) : bytes[i];
      next ^= kTables[7 - i][byte];
    }
    crc = next;
  }
  for (; count > 0; --count, ++bytes) crc = crc >> 8 ^ kTables[0][(crc ^ *bytes) & 255];
  return ~crc;
}
