#pragma once

// Where one state is likely: pixels that have only that state around them, in the row above and in the three
// rows around them in the frame before, two pixels to either side. Found for 64 pixels at a time.
//
// Thread: a value.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/depth/mask/mask_planes.h"

namespace copresence::depth {

/// One bit per pixel of a row: whether something holds there. Words have a margin of one on either side.
class RowBits {
 public:
  explicit RowBits(int width) : words_(static_cast<std::size_t>((width + 63) / 64 + 2)) {}

  std::uint64_t* words() { return words_.data() + 1; }

  /// How many pixels from x on, at most `most`, have this bit.
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

/// Where a row's pixels have only one state around them, in the row above and the three rows around it in the
/// frame before, two pixels to either side.
class MaskContext {
 public:
  explicit MaskContext(int width)
      : count_(static_cast<std::size_t>((width + 63) / 64 + 2)),
        rows_(4 * count_),
        alike_(3, RowBits(width)),
        any_(width) {}

  void look(const MaskPlanes& now, const MaskPlanes& earlier, int y) {
    std::uint64_t *const m_all = rows_.data(), *const m_any = m_all + count_, *const f_all = m_any + count_,
                         *const f_any = f_all + count_;
    gather(now.measured, earlier.measured, y, m_all, m_any);
    gather(now.filled, earlier.filled, y, f_all, f_any);
    std::uint64_t *const hole = alike_[0].words(), *const measured = alike_[1].words(),
                         *const filled = alike_[2].words(), *const any = any_.words();
    for (std::size_t i = 1; i + 1 < count_; ++i) {
      measured[i - 1] = wide_all(m_all + i);
      filled[i - 1] = wide_all(f_all + i);
      hole[i - 1] = ~wide_any(m_any + i, f_any + i);
      any[i - 1] = measured[i - 1] | filled[i - 1] | hole[i - 1];
    }
  }

  // By the state.
  const RowBits& alike(int state) const { return alike_[static_cast<std::size_t>(state)]; }
  const RowBits& any() const { return any_; }

 private:
  void gather(const BitPlane& now, const BitPlane& earlier, int y, std::uint64_t* all,
              std::uint64_t* any) const {
    const std::uint64_t* const above = now.row(y - 1) - 1;
    const std::uint64_t* const before_above = earlier.row(y - 1) - 1;
    const std::uint64_t* const before = earlier.row(y) - 1;
    const std::uint64_t* const before_below = earlier.row(y + 1) - 1;
    for (std::size_t i = 0; i < count_; ++i) {
      all[i] = above[i] & before_above[i] & before[i] & before_below[i];
      any[i] = above[i] | before_above[i] | before[i] | before_below[i];
    }
  }
  static std::uint64_t wide_all(const std::uint64_t* w) {
    return *w & (*w << 1 | w[-1] >> 63) & (*w << 2 | w[-1] >> 62) & (*w >> 1 | w[1] << 63) &
           (*w >> 2 | w[1] << 62);
  }
  static std::uint64_t wide_any(const std::uint64_t* a, const std::uint64_t* b) {
    const std::uint64_t before = a[-1] | b[-1], w = *a | *b, after = a[1] | b[1];
    return w | w << 1 | before >> 63 | w << 2 | before >> 62 | w >> 1 | after << 63 | w >> 2 | after << 62;
  }

  std::size_t count_;  // words of a row with its margins
  std::vector<std::uint64_t> rows_;
  std::vector<RowBits> alike_;
  RowBits any_;
};

}  // namespace copresence::depth
