#pragma once

// Binary adaptive range coding: writes decisions in the number of bits that their probability deserves.
//
// The interval is kept in 32 bits and renormalised bytewise; a carry runs back into the bytes already written
// (the construction of Martin 1979, as in LZMA). A reader past the end of its bytes sees zeros, so any bytes
// decode to something in bounded time; whether they are the right ones is for a checksum to say.
//
// Thread: distinct objects are independent.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace copresence::depth {

/// The learnt probability of one decision being 1, in 1/65536. Learns fast at first, then slowly: the n-th
/// decision moves it by 1/(n + 1.5) of its error, until n reaches `kMemory`.
class BinaryContext {
 public:
  std::uint32_t probability_of_one() const { return probability_; }

  void learn(bool bit) {
    const std::int32_t target = bit ? 65536 - kLeast : kLeast;
    probability_ = static_cast<std::uint16_t>(probability_ + ((target - probability_) * kRate[seen_] >> 15));
    seen_ = static_cast<std::uint16_t>(seen_ + (seen_ < kMemory));
  }

 private:
  static constexpr std::int32_t kLeast = 32;  // of 65536: certainty costs 1/1400 bit
  static constexpr int kMemory = 160;  // decisions; the best of 40 to 400 on moving and static recordings
  static constexpr std::array<std::int32_t, kMemory + 1> kRate = [] {
    std::array<std::int32_t, kMemory + 1> rate{};
    for (int n = 0; n <= kMemory; ++n) rate[n] = static_cast<std::int32_t>(32768 / (n + 1.5));
    return rate;
  }();

  std::uint16_t probability_ = 32768;
  std::uint16_t seen_ = 0;
};

/// A cursor into a caller's room: small and copied freely, so that a loop can keep it in registers.
class RangeEncoder {
 public:
  /// What is left to write into must at any time be kMostBytes a decision, and kEndBytes.
  static constexpr std::size_t kMostBytes = 2, kEndBytes = 2;

  explicit RangeEncoder(std::uint8_t* room) : next_(room) {}

  void encode(BinaryContext& model, bool bit) {
    const std::uint32_t split = split_of(range_, model);
    const std::uint32_t one =
        -static_cast<std::uint32_t>(bit);  // all ones for 1: no branch that could be mispredicted
    low_ += split & ~one;
    range_ = (split & one) | ((range_ - split) & ~one);
    model.learn(bit);
    while (range_ < kBottom) {
      range_ <<= 8;
      shift_low();
    }
  }

  /// Writes what is left to write and returns the end of the bytes; those of zero at the end may be left off.
  std::uint8_t* finish();

  /// Goes on in another room that begins with what was written so far.
  void move_to(std::uint8_t* next) { next_ = next; }
  std::uint8_t* next() const { return next_; }

  /// The part of [0, range) that stands for 1: never empty, never all.
  static std::uint32_t split_of(std::uint32_t range, const BinaryContext& model) {
    return (range >> 16) * model.probability_of_one();
  }

  static constexpr std::uint32_t kBottom = 1u << 24;

 private:
  void shift_low() {
    if (low_ >> 32) {
      for (std::uint8_t* byte = next_ - 1; ++*byte == 0;) --byte;  // the first byte never overflows
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
    // A branch, since what follows would wait for its outcome: most decisions are well predicted.
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
