#pragma once

// Entropy coder: asymmetric numeral systems, the range variant (Duda 2013). A symbol takes about
// -log2(its probability) bits and is decoded with one multiplication. Two interleaved streams of
// symbols, each with its own state, share the 16-bit words of the output. The streams are
// independent, so a processor can work on both at the same time.
//
// The symbol that is encoded last is decoded first. The writer therefore collects all symbols and
// encodes them backwards at the end. The reader reads zeros past the end of its bytes, and decodes
// any bytes in bounded time. Thread: distinct objects are independent.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/depth/entropy/adaptive_cdf.h"

namespace copresence::depth {

/// A cursor into the caller's buffer. The cursor is cheap to copy, so a loop can keep it in
/// registers.
class AnsWriter {
 public:
  static constexpr int kStreams = 2;

  /// Requires one element of `buffer` for each symbol.
  explicit AnsWriter(std::uint32_t* buffer) : begin_(buffer), next_(buffer) {}

  /// Requires stream < kStreams and a frequency above 0.
  void put(unsigned stream, AdaptiveCdf::Slot slot) {
    *next_++ = stream << kStreamAt | slot.start << kStartAt | slot.frequency;
  }

  /// Appends a number below 2^bits. All such numbers have the same frequency. Requires bits <=
  /// kBits.
  void put_bits(unsigned stream, std::uint32_t value, int bits) {
    put(stream, {value << (AdaptiveCdf::kBits - bits), 1u << (AdaptiveCdf::kBits - bits)});
  }

  /// Encodes all symbols and appends them to `out`. Overwrites and then empties the buffer.
  void finish(std::vector<std::uint8_t>& out);

 private:
  // Bit positions of start and stream in a symbol's 32 bits, above the frequency.
  static constexpr int kStartAt = AdaptiveCdf::kBits + 1, kStreamAt = 31;

  std::uint32_t* begin_;
  std::uint32_t* next_;
};

class AnsReader {
 public:
  explicit AnsReader(std::span<const std::uint8_t> bytes);

  unsigned get(unsigned stream, const AdaptiveCdf& model) {
    const std::uint32_t point = state_[stream] & kMask;
    const unsigned symbol = model.symbol_at(point);
    advance(stream, model.slot(symbol), point);
    return symbol;
  }

  /// Requires 0 <= bits <= kBits.
  std::uint32_t get_bits(unsigned stream, int bits) {
    const std::uint32_t point = state_[stream] & kMask;
    const int shift = AdaptiveCdf::kBits - bits;
    advance(stream, {point >> shift << shift, 1u << shift}, point);
    return point >> shift;
  }

 private:
  static constexpr std::uint32_t kMask = (1u << AdaptiveCdf::kBits) - 1;

  void advance(unsigned stream, AdaptiveCdf::Slot slot, std::uint32_t point) {
    std::uint32_t state = slot.frequency * (state_[stream] >> AdaptiveCdf::kBits) + point - slot.start;
    if (state < 1u << 16) state = state << 16 | word();
    state_[stream] = state;
  }

  std::uint32_t word() {
    if (end_ - next_ < 2) return 0;
    next_ += 2;
    return static_cast<std::uint32_t>(next_[-2] | next_[-1] << 8);
  }

  const std::uint8_t* next_;
  const std::uint8_t* end_;
  std::uint32_t state_[AnsWriter::kStreams];
};

}  // namespace copresence::depth
