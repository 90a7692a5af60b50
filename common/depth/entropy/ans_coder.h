#pragma once

// Asymmetric numeral systems (Duda 2013, the range variant): symbols in the number of bits that their frequency
// deserves, decoded with one multiplication each. Two states, the lanes, take turns as the caller says, in one stream
// of 16-bit words, so that a processor works on both at a time.
//
// The writer notes what is to be written and writes it backwards at the end, since the last symbol written is the first one
// read. A reader past the end of its bytes sees zeros: any bytes decode to something, in bounded time.
//
// Thread: distinct objects are independent.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/depth/entropy/adaptive_cdf.h"

namespace copresence::depth {

/// A cursor into a caller's room: small and copied freely, so that a loop can keep it in registers.
class AnsWriter {
 public:
  static constexpr int kLanes = 2;

  /// Requires room for every symbol put.
  explicit AnsWriter(std::uint32_t* room) : begin_(room), next_(room) {}

  /// Requires lane < kLanes and a frequency that is not 0.
  void put(unsigned lane, AdaptiveCdf::Slot slot) {
    *next_++ = lane << kLaneAt | slot.start << kStartAt | slot.frequency;
  }

  /// A number of so many bits, at most kBits, all numbers alike.
  void put_bits(unsigned lane, std::uint32_t value, int bits) {
    put(lane, {value << (AdaptiveCdf::kBits - bits), 1u << (AdaptiveCdf::kBits - bits)});
  }

  /// Appends everything to `out`; the room is needed for it, and free afterwards.
  void finish(std::vector<std::uint8_t>& out);

 private:
  static constexpr int kStartAt = AdaptiveCdf::kBits + 1,
                       kLaneAt = 31;  // in a symbol's 32 bits, above its frequency

  std::uint32_t* begin_;
  std::uint32_t* next_;
};

class AnsReader {
 public:
  explicit AnsReader(std::span<const std::uint8_t> bytes);

  unsigned get(unsigned lane, const AdaptiveCdf& model) {
    const std::uint32_t point = state_[lane] & kMask;
    const unsigned symbol = model.symbol_at(point);
    advance(lane, model.slot(symbol), point);
    return symbol;
  }

  /// Requires 0 <= bits <= kBits.
  std::uint32_t get_bits(unsigned lane, int bits) {
    const std::uint32_t point = state_[lane] & kMask;
    const int shift = AdaptiveCdf::kBits - bits;
    advance(lane, {point >> shift << shift, 1u << shift}, point);
    return point >> shift;
  }

 private:
  static constexpr std::uint32_t kMask = (1u << AdaptiveCdf::kBits) - 1;

  void advance(unsigned lane, AdaptiveCdf::Slot slot, std::uint32_t point) {
    std::uint32_t state = slot.frequency * (state_[lane] >> AdaptiveCdf::kBits) + point - slot.start;
    if (state < 1u << 16) state = state << 16 | word();
    state_[lane] = state;
  }

  std::uint32_t word() {
    if (end_ - next_ < 2) return 0;
    next_ += 2;
    return static_cast<std::uint32_t>(next_[-2] | next_[-1] << 8);
  }

  const std::uint8_t* next_;
  const std::uint8_t* end_;
  std::uint32_t state_[AnsWriter::kLanes];
};

}  // namespace copresence::depth
