#pragma once

// One bit per pixel, packed into 64-bit words, with a margin of zeros around the image, so that a
// neighbourhood can be read anywhere without asking where the image ends.
//
// Thread: a value.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace copresence::depth {

class BitPlane {
 public:
  static constexpr int kMargin = 2;  ///< rows of zeros above and below; left and right there are 64 bits

  BitPlane() = default;
  BitPlane(int width, int height)
      : words_(static_cast<std::size_t>(row_words(width)) * (height + 2 * kMargin)),
        row_words_(row_words(width)) {}

  void clear() { std::fill(words_.begin(), words_.end(), 0); }

  /// Eight pixels a byte, from x = 0, lowest bit first. Requires -kMargin <= y < height + kMargin.
  /// What lies beyond the width within the last word must stay 0.
  std::uint64_t* row(int y) { return words_.data() + offset(y) + 1; }
  const std::uint64_t* row(int y) const { return words_.data() + offset(y) + 1; }

  /// 64 bits of a row from pixel x on: pixel x + i is bit i. Requires -64 <= x, x < width.
  static std::uint64_t window(const std::uint64_t* row, int x) {
    const int word = x >> 6, bit = x & 63;
    return row[word] >> bit | row[word + 1] << 1 << (63 - bit);
  }

 private:
  static int row_words(int width) { return (width + 63) / 64 + 2; }
  std::size_t offset(int y) const { return static_cast<std::size_t>(y + kMargin) * row_words_; }

  std::vector<std::uint64_t> words_;
  int row_words_ = 0;
};

}  // namespace copresence::depth
