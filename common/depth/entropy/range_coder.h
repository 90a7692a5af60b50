#pragma once

// Binary adaptive range coder: codes a decision in about -log2(its probability) bits.
//
// The interval has 32 bits and is renormalised by bytes. A carry propagates into the bytes already
// written (Martin 1979, as in LZMA). The decoder reads zeros past the end of its bytes. Any bytes
// decode to some decisions in bounded time; only a checksum can detect damage. Thread: distinct
// objects are independent.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace copresence::depth {

/// Adaptive probability that a decision is 1, in units of 1/65536. The probability adapts fast at
/// first, then slowly. The n-th decision corrects 1/(n + 1.5) of the error, until n reaches
/// kMemory.
class BinaryContext {
 public:
  std::uint32_t probability_of_one() const { return probability_; }

  void learn(bool bit) {
    const std::int32_t target = bit ? 65536 - kLeast : kLeast;
    probability_ = static_cast<std::uint16_t>(probability_ + ((target - probability_) * kRate[seen_] >> 15));
    seen_ = static_cast<std::uint16_t>(seen_ + (seen_ < kMemory));
  }

 private:
  static constexpr std::int32_t kLeast = 32;  // In 1/65536; a certain decision then costs 1/1400 bit.
  static constexpr int kMemory = 160;         // Number of decisions; the best of 40 to 400 on recordings.
  static constexpr std::array<std::int32_t, kMemory + 1> kRate = [] {
    std::array<std::int32_t, kMemory + 1> rate{};
    for (int n = 0; n <= kMemory; ++n) rate[n] = static_cast<std::int32_t>(32768 / (n + 1.5));
    return rate;
  }();

  std::uint16_t probability_ = 32768;
  std::uint16_t seen_ = 0;
};

/// A cursor into the caller's buffer. The cursor is cheap to copy, so a loop can keep it in
/// registers.
class RangeEncoder {
 public:
  /// The buffer must have room for kMostBytes for each decision, plus kEndBytes.
  static constexpr std::size_t kMostBytes = 2, kEndBytes = 2;

  explicit RangeEncoder(std::uint8_t* buffer) : next_(buffer) {}

  void encode(BinaryContext& model, bool bit) {
    const std::uint32_t split = split_of(range_, model);
    // All ones if the bit is 1. A branch on the bit would often be mispredicted.
    const std::uint32_t one = -static_cast<std::uint32_t>(bit);
    low_ += split & ~one;
    range_ = (split & one) | ((range_ - split) & ~one);
    model.learn(bit);
    while (range_ < kBottom) {
      range_ <<= 8;
      shift_low();
    }
  }

  /// Writes the last bytes and returns their end. Zero bytes at the end may be omitted.
  std::uint8_t* finish() {
    // Every number in the interval decodes correctly. The number with most zero bytes at its end is
    // the shortest, since the decoder reads zeros past the end. The range is at least kBottom, so
    // one byte below the carry is enough.
    low_ = (low_ + kBottom - 1) & ~std::uint64_t{kBottom - 1};
    shift_low();
    return next_;
  }

  /// Continues in another buffer, which begins with the bytes written so far.
  void move_to(std::uint8_t* next) { next_ = next; }
  std::uint8_t* next() const { return next_; }

  /// Divides [0, range): [0, split) stands for 1, the rest for 0. Neither part is empty.
  static std::uint32_t split_of(std::uint32_t range, const BinaryContext& model) {
    return (range >> 16) * model.probability_of_one();
  }

  static constexpr std::uint32_t kBottom = 1u << 24;

 private:
  void shift_low() {
    if (low_ >> 32) {
      // A carry never passes the first byte.
      for (std::uint8_t* byte = next_ - 1; ++*byte == 0;) --byte;
    }
    *next_++ = static_cast<std::uint8_t>(low_ >> 24);
    low_ = (low_ & 0x00ffffffu) << 8;
  }

  std::uint8_t* next_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffu;
};

class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::uint8_t> bytes)
      : next_(bytes.data()), end_(bytes.data() + bytes.size()) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | take();
  }

  bool decode(BinaryContext& model) {
    const std::uint32_t split = RangeEncoder::split_of(range_, model);
    const bool bit = code_ < split;
    // Most decisions are well predicted. Without a branch, later instructions would wait for each
    // decision.
    if (bit) {
      range_ = split;
    } else {
      code_ -= split;
      range_ -= split;
    }
    model.learn(bit);
    while (range_ < RangeEncoder::kBottom) {
      range_ <<= 8;
      code_ = code_ << 8 | take();
    }
    return bit;
  }

 private:
  std::uint32_t take() { return next_ != end_ ? *next_++ : 0u; }

  const std::uint8_t* next_;
  const std::uint8_t* end_;
  std::uint32_t range_ = 0xffffffffu;
  std::uint32_t code_ = 0;
};

}  // namespace copresence::depth
