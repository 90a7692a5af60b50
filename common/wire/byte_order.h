#pragma once

// Writes and reads little-endian numbers on machines of any byte order. Thread: distinct objects
// are independent.

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace copresence::wire {

class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& out) : out_(out) {}

  template <std::unsigned_integral Number>
  void number(Number value) {
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      out_.push_back(static_cast<std::uint8_t>(std::uint64_t{value} >> (8 * i)));
    }
  }
  void real(double value) { number(std::bit_cast<std::uint64_t>(value)); }
  void text(std::string_view value) {  // Two bytes of length, then the text.
    number(static_cast<std::uint16_t>(value.size()));
    out_.insert(out_.end(), value.begin(), value.end());
  }

 private:
  std::vector<std::uint8_t>& out_;
};

/// Reading past the end returns zeros and makes ok() false. Read all fields, then check complete().
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> in) : in_(in) {}

  template <std::unsigned_integral Number>
  Number number() {
    if (in_.size() < sizeof(Number)) return past_end<Number>();
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(Number); ++i) value |= std::uint64_t{in_[i]} << (8 * i);
    in_ = in_.subspan(sizeof(Number));
    return static_cast<Number>(value);
  }
  double real() { return std::bit_cast<double>(number<std::uint64_t>()); }
  std::string text() {
    const std::size_t size = number<std::uint16_t>();
    if (in_.size() < size) return past_end<std::string>();
    std::string value(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(size));
    in_ = in_.subspan(size);
    return value;
  }

  /// True if no read went past the end.
  bool ok() const { return !short_; }
  /// True if ok() and no bytes are left.
  bool complete() const { return !short_ && in_.empty(); }

 private:
  template <class Value>
  Value past_end() {
    short_ = true;
    in_ = {};
    return Value{};
  }

  std::span<const std::uint8_t> in_;
  bool short_ = false;
};

}  // namespace copresence::wire
