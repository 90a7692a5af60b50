#include "common/depth/side_data_seal.h"

#include <array>
#include <cassert>

namespace copresence::depth {
namespace {

constexpr std::array<std::uint32_t, 256> kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1;
    table[i] = c;
  }
  return table;
}();

// CRC-32 (IEEE 802.3) in its running, uninverted form.
std::uint32_t crc(std::uint32_t state, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) state = kCrcTable[(state ^ byte) & 255] ^ state >> 8;
  return state;
}

constexpr std::uint32_t kKeyframe = 0x6b657966;  // what a chain begins with: "keyf"

// The table's length goes in too, so that bytes cannot wander from the table's end to the mask's beginning.
std::uint32_t seal(std::uint32_t chain, std::span<const std::uint8_t> table,
                   std::span<const std::uint8_t> mask) {
  const auto size = static_cast<std::uint32_t>(table.size());
  const std::array<std::uint8_t, 4> length{
      static_cast<std::uint8_t>(size), static_cast<std::uint8_t>(size >> 8),
      static_cast<std::uint8_t>(size >> 16), static_cast<std::uint8_t>(size >> 24)};
  return ~crc(crc(crc(~chain, length), table), mask);
}

}  // namespace

void SideDataSeal::close(bool keyframe, std::span<const std::uint8_t> table,
                         std::vector<std::uint8_t>& mask) {
  assert(keyframe || chain_);
  const std::uint32_t value = seal(keyframe ? kKeyframe : *chain_, table, mask);
  for (int shift = 0; shift < 32; shift += 8) mask.push_back(static_cast<std::uint8_t>(value >> shift));
  chain_ = value;
}

std::optional<std::span<const std::uint8_t>> SideDataSeal::open(bool keyframe,
                                                                std::span<const std::uint8_t> table,
                                                                std::span<const std::uint8_t> mask) {
  if (keyframe) chain_ = kKeyframe;
  if (!chain_) return std::nullopt;
  if (mask.size() < kBytes) {
    chain_.reset();
    return std::nullopt;
  }
  const auto body = mask.first(mask.size() - kBytes);
  const auto tail = mask.last(kBytes);
  const std::uint32_t expected = seal(*chain_, table, body);
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | tail[i];
  if (value != expected) {
    chain_.reset();
    return std::nullopt;
  }
  chain_ = value;
  return body;
}

}  // namespace copresence::depth
