#pragma once

// Pixel states as bit planes, 64 pixels a word, for the coder of the validity mask. Thread:
// distinct objects are independent.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/frame/image.h"

namespace copresence::depth {

/// One bit per pixel, packed into 64-bit words. A margin of zeros around the image allows reading a
/// neighbourhood anywhere without tests for the image's border.
class BitPlane {
 public:
  static constexpr int kMargin = 2;  ///< In rows above and below. Left and right are 64 bits.

  BitPlane() = default;
  BitPlane(int width, int height)
      : words_(static_cast<std::size_t>(row_words(width)) * (height + 2 * kMargin)),
        row_words_(row_words(width)) {}

  void clear() { std::fill(words_.begin(), words_.end(), 0); }

  /// Pixel x is bit x % 64 of word x / 64. Requires -kMargin <= y < height + kMargin. Bits beyond
  /// the width in the last word must stay 0.
  std::uint64_t* row(int y) { return words_.data() + offset(y) + 1; }
  const std::uint64_t* row(int y) const { return words_.data() + offset(y) + 1; }

  /// Returns 64 bits of a row from pixel x on: pixel x + i is bit i. Requires -64 <= x < width.
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

/// The states of an image. A hole is in neither plane.
struct MaskPlanes {
  BitPlane measured, filled;
  void clear() { measured.clear(), filled.clear(); }
};

/// Requires planes of the states' shape. Returns true if any pixel is filled.
bool pack(const StateImage& states, MaskPlanes& planes);

/// Requires planes of the states' shape.
void unpack(const MaskPlanes& planes, StateImage& states);

/// One bit per pixel of a row. There is a margin of one word on either side.
class RowBits {
 public:
  explicit RowBits(int width) : words_(static_cast<std::size_t>((width + 63) / 64 + 2)) {}

  std::uint64_t* words() { return words_.data() + 1; }

  /// Returns the number of consecutive pixels from x on that have this bit, at most `most`.
  int run_of(bool bit, int x, int most) const {
    const std::uint64_t flip = bit ? 0 : ~std::uint64_t{0};
    const std::uint64_t* word = words_.data() + 1 + (x >> 6);
    int run = std::min(std::countr_one((*word ^ flip) >> (x & 63)), 64 - (x & 63));
    if (run == 64 - (x & 63)) {
      while (run < most) {
        const int more = std::countr_one(*++word ^ flip);
        run += more;
        if (more < 64) break;
      }
    }
    return std::min(run, most);
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// Finds the pixels of a row whose whole neighbourhood has the same state. Such pixels likely have
/// this state, too. The neighbourhood is the row above and, in the frame before, three rows around
/// the pixel, two pixels to either side.
class MaskContext {
 public:
  explicit MaskContext(int width);

  /// Finds these pixels in row y of `now`. `earlier` has the previous frame.
  void find(const MaskPlanes& now, const MaskPlanes& earlier, int y);

  /// Pixels whose neighbourhood has this state everywhere.
  const RowBits& uniform(int state) const { return uniform_[static_cast<std::size_t>(state)]; }
  /// Pixels whose whole neighbourhood has one state, whichever it is.
  const RowBits& uniform() const { return any_uniform_; }

 private:
  void gather(const BitPlane& now, const BitPlane& earlier, int y, std::uint64_t* all,
              std::uint64_t* any) const;

  std::size_t count_;  // Number of words in a row with its margins.
  std::vector<std::uint64_t> rows_;
  std::vector<RowBits> uniform_;  // Indexed by state.
  RowBits any_uniform_;
};

}  // namespace copresence::depth
