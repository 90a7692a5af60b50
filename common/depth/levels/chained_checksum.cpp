#include "common/depth/levels/chained_checksum.h"

#include <array>
#include <cassert>

namespace copresence::depth {
namespace {

constexpr int kSlices = 4;

// kCrcTables[k][b]: what byte b does to the CRC when k more bytes follow it ("slicing by 4", Kounavis and Berry 2008).
constexpr auto kCrcTables = [] {
  std::array<std::array<std::uint32_t, 256>, kSlices> tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1;
    tables[0][i] = c;
  }
  for (std::uint32_t i = 0; i < 256; ++i) {
    for (int k = 1; k < kSlices; ++k)
      tables[k][i] = tables[k - 1][i] >> 8 ^ tables[0][tables[k - 1][i] & 255];
  }
  return tables;
}();

// CRC-32 (IEEE 802.3) in its running, uninverted form.
std::uint32_t crc(std::uint32_t state, std::span<const std::uint8_t> bytes) {
  std::size_t i = 0;
  for (; i + kSlices <= bytes.size(); i += kSlices) {
    state = kCrcTables[3][(state ^ bytes[i]) & 255] ^ kCrcTables[2][(state >> 8 ^ bytes[i + 1]) & 255] ^
            kCrcTables[1][(state >> 16 ^ bytes[i + 2]) & 255] ^ kCrcTables[0][state >> 24 ^ bytes[i + 3]];
  }
  for (; i < bytes.size(); ++i) state = kCrcTables[0][(state ^ bytes[i]) & 255] ^ state >> 8;
  return state;
}

constexpr std::uint32_t kKeyframe = 0x6b657966;  // what a chain begins with: "keyf"

// Lengths go in too, so that bytes cannot wander from the end of one to the beginning of the next.
std::uint32_t seal(std::uint32_t chain, std::span<const std::uint8_t> table,
                   std::span<const std::uint8_t> samples, std::span<const std::uint8_t> mask) {
  const auto with_length = [](std::uint32_t state, std::span<const std::uint8_t> bytes) {
    std::array<std::uint8_t, 4> length;
    for (int i = 0; i < 4; ++i) length[i] = static_cast<std::uint8_t>(bytes.size() >> 8 * i);
    return crc(crc(state, length), bytes);
  };
  return ~crc(with_length(with_length(~chain, table), samples), mask);
}

}  // namespace

void ChainedChecksum::close(bool keyframe, std::span<const std::uint8_t> table,
                            std::span<const std::uint8_t> samples, std::vector<std::uint8_t>& mask) {
  assert(keyframe || chain_);
  const std::uint32_t value = seal(keyframe ? kKeyframe : *chain_, table, samples, mask);
  for (int shift = 0; shift < 32; shift += 8) mask.push_back(static_cast<std::uint8_t>(value >> shift));
  chain_ = value;
}

std::optional<std::span<const std::uint8_t>> ChainedChecksum::open(bool keyframe,
                                                                   std::span<const std::uint8_t> table,
                                                                   std::span<const std::uint8_t> samples,
                                                                   std::span<const std::uint8_t> mask) {
  if (keyframe) chain_ = kKeyframe;
  if (!chain_) return std::nullopt;
  if (mask.size() < kBytes) {
    chain_.reset();
    return std::nullopt;
  }
  const auto body = mask.first(mask.size() - kBytes);
  const auto tail = mask.last(kBytes);
  const std::uint32_t expected = seal(*chain_, table, samples, body);
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
