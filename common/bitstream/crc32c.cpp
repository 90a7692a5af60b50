#include "common/bitstream/crc32c.h"

#include <array>
#include <cstddef>

namespace copresence::bitstream {
namespace {

constexpr int kSlices = 8;

// tables[k][b]: what byte b does to the CRC when k more bytes follow it ("slicing by 8", Kounavis and Berry
// 2008).
constexpr auto make_tables() {
  std::array<std::array<std::uint32_t, 256>, kSlices> tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0x82F63B78u : 0u);
    tables[0][byte] = crc;
  }
  for (int slice = 1; slice < kSlices; ++slice) {
    for (int byte = 0; byte < 256; ++byte) {
      const std::uint32_t shorter = tables[slice - 1][byte];
      tables[slice][byte] = (shorter >> 8) ^ tables[0][shorter & 255];
    }
  }
  return tables;
}

constexpr auto kTables = make_tables();

}  // namespace

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  std::uint32_t crc = ~before;
  std::size_t at = 0;
  for (; at + kSlices <= bytes.size(); at += kSlices) {
    const std::uint8_t* const b = bytes.data() + at;
    crc = kTables[7][b[0] ^ (crc & 255)] ^ kTables[6][b[1] ^ ((crc >> 8) & 255)] ^
          kTables[5][b[2] ^ ((crc >> 16) & 255)] ^ kTables[4][b[3] ^ (crc >> 24)] ^ kTables[3][b[4]] ^
          kTables[2][b[5]] ^ kTables[1][b[6]] ^ kTables[0][b[7]];
  }
  for (; at < bytes.size(); ++at) crc = (crc >> 8) ^ kTables[0][(crc ^ bytes[at]) & 255];
  return ~crc;
}

}  // namespace copresence::bitstream
