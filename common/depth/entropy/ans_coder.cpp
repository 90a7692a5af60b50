#include "common/depth/entropy/ans_coder.h"

#include <algorithm>
#include <cstring>

namespace copresence::depth {
namespace {

constexpr std::uint32_t kLeastState = 1u << 16;  // States are from this value to 2^32 - 1.

}  // namespace

void AnsWriter::finish(std::vector<std::uint8_t>& out) {
  constexpr std::uint32_t kFrequency = (1u << kStartAt) - 1, kStart = (1u << AdaptiveCdf::kBits) - 1;
  std::uint32_t state[kStreams];
  std::fill_n(state, kStreams, kLeastState);
  // Each symbol of 32 bits yields at most one word of 16 bits. So the words can be written over the
  // symbols that are already encoded.
  auto* byte = reinterpret_cast<std::uint8_t*>(next_);
  const std::uint8_t* const end = byte;
  for (const std::uint32_t* symbol = next_; symbol != begin_;) {
    const std::uint32_t packed = *--symbol;
    const std::uint32_t frequency = packed & kFrequency;
    std::uint32_t& x = state[packed >> kStreamAt];
    if (x >> (32 - AdaptiveCdf::kBits) >= frequency) {
      *--byte = static_cast<std::uint8_t>(x >> 8);
      *--byte = static_cast<std::uint8_t>(x);
      x >>= 16;
    }
    x = (x / frequency << AdaptiveCdf::kBits) + x % frequency + (packed >> kStartAt & kStart);
  }
  for (const std::uint32_t x : state) {
    for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(x >> shift));
  }
  out.insert(out.end(), static_cast<const std::uint8_t*>(byte), end);
  next_ = begin_;
}

AnsReader::AnsReader(std::span<const std::uint8_t> bytes)
    : next_(bytes.data()), end_(bytes.data() + bytes.size()) {
  for (std::uint32_t& state : state_) {
    state = word();
    state |= word() << 16;
  }
}

}  // namespace copresence::depth
